#include "router/io/dds/send_queue.h"

#include <algorithm>
#include <cstring>

#include "router/link/bundle.h"

namespace tims::io {

using link::kBundleSizeBytes;

bool SendQueue::put(const link::Train& train) {
  if (train.bytes.empty() || train.datagram_size == 0) return true;
  const std::size_t datagrams =
      (train.bytes.size() + train.datagram_size - 1) / train.datagram_size;
  if (train.bytes.size() + datagrams * kBundleSizeBytes > size_ - used_) return false;
  if (!ring_) ring_ = std::make_unique_for_overwrite<std::byte[]>(size_);
  for (std::span<const std::byte> rest = train.bytes; !rest.empty();) {
    const auto datagram = rest.first(std::min(train.datagram_size, rest.size()));
    const std::array size{static_cast<std::byte>(datagram.size() & 0xFF),
                          static_cast<std::byte>(datagram.size() >> 8)};
    write(size);
    write(datagram);
    rest = rest.subspan(datagram.size());
  }
  return true;
}

void SendQueue::write(std::span<const std::byte> bytes) {
  const std::size_t before_wrap = std::min(bytes.size(), size_ - end_);
  std::memcpy(ring_.get() + end_, bytes.data(), before_wrap);
  std::memcpy(ring_.get(), bytes.data() + before_wrap, bytes.size() - before_wrap);
  end_ = (end_ + bytes.size()) % size_;
  used_ += bytes.size();
}

std::size_t SendQueue::datagram_size_at(std::size_t position) const {
  return std::to_integer<std::size_t>(ring_[position % size_]) |
         std::to_integer<std::size_t>(ring_[(position + 1) % size_]) << 8;
}

SendQueue::Front SendQueue::front(std::size_t bytes_max) const {
  Front front;
  while (front.bytes < used_) {
    const std::size_t next = kBundleSizeBytes + datagram_size_at(first_ + front.bytes);
    if (front.datagrams > 0 && front.bytes + next > bytes_max) break;
    front.bytes += next;
    ++front.datagrams;
  }
  if (front.bytes == 0) return front;
  const std::size_t before_wrap = std::min(front.bytes, size_ - first_);
  front.parts = {std::span<const std::byte>(ring_.get() + first_, before_wrap),
                 std::span<const std::byte>(ring_.get(), front.bytes - before_wrap)};
  return front;
}

void SendQueue::remove(const Front& front) {
  used_ -= front.bytes;
  first_ = (first_ + front.bytes) % size_;
  // A queue that is used little stays in few pages.
  if (used_ == 0) first_ = end_ = 0;
}

}  // namespace tims::io

#include "router/link/datagram_stream.h"

#include <algorithm>
#include <utility>

#include "router/link/datagram.h"
#include "router/link/transport.h"

namespace tims::link {

static_assert(DatagramStream::kSizeBytes == kBatchSizeBytes && kDatagramMax <= kBatchedMax);

void DatagramStream::put(std::span<const std::byte> datagram, std::vector<std::byte>& out) {
  out.push_back(static_cast<std::byte>(datagram.size()));
  out.push_back(static_cast<std::byte>(datagram.size() >> 8));
  out.insert(out.end(), datagram.begin(), datagram.end());
}

std::size_t DatagramStream::whole_size(std::span<const std::byte> begin) {
  if (begin.size() < kSizeBytes) return 0;
  const std::size_t size = Batch::size_at(begin, 0);
  is_broken_ = size == 0 || size > kDatagramMax;
  return kSizeBytes + size;
}

std::span<std::byte> DatagramStream::next(std::span<std::byte>& bytes) {
  if (is_broken_) return {};
  if (const std::size_t whole = part_.empty() ? whole_size(bytes) : 0;
      whole > 0 && whole <= bytes.size() && !is_broken_) {
    const auto datagram = bytes.subspan(kSizeBytes, whole - kSizeBytes);
    bytes = bytes.subspan(whole);
    return datagram;
  }
  while (!is_broken_) {
    const std::size_t whole = whole_size(part_);
    const std::size_t wanted = (whole == 0 ? kSizeBytes : whole) - part_.size();
    const auto taken = bytes.first(std::min(wanted, bytes.size()));
    if (is_broken_) break;
    part_.insert(part_.end(), taken.begin(), taken.end());
    bytes = bytes.subspan(taken.size());
    if (taken.size() < wanted) break;
    if (whole == 0) continue;
    // What follows of `bytes` may begin another one.
    std::swap(part_, passed_);
    part_.clear();
    return std::span(passed_).subspan(kSizeBytes);
  }
  return {};
}

}  // namespace tims::link

#include "components/devices/io/video_exchange.h"

#include <algorithm>
#include <cstring>
#include <new>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace rack::device {

using tims::Errc;
using tims::Error;
using tims::Result;
using tims::os::File;
using tims::os::system_error;

namespace detail {

// Number of the slot in the middle, with kNew if the reader has not taken it.
struct VideoMiddle {
  std::atomic<std::uint32_t> slot{1};
};
static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

void Unmap::operator()(std::byte* begin) const { ::munmap(begin, size); }

}  // namespace detail

namespace {

constexpr std::uint32_t kSlots = 3;
constexpr std::uint32_t kNew = 4;
constexpr std::uint32_t kSlotMask = 3;
constexpr std::size_t kPage = 4096;
constexpr std::size_t kSlotBytes = kPage + kVideoFrameBytesMax;
constexpr std::size_t kMemoryBytes = kPage + kSlots * kSlotBytes;
static_assert(kVideoFrameBytesMax % kPage == 0);

// At the beginning of a slot; the frame follows on the next page.
struct SlotHead {
  VideoHead head{};
  std::int64_t when = 0;  // ns
  std::uint64_t size = 0;
};

std::size_t begin_of(std::uint32_t slot) { return kPage + slot * kSlotBytes; }

Result<detail::VideoMemory> map(int file, std::size_t size) {
  void* const begin = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (begin == MAP_FAILED) return system_error("cannot map the memory of video frames");
  return detail::VideoMemory(static_cast<std::byte*>(begin), detail::Unmap{size});
}

detail::VideoMiddle& middle_of(const detail::VideoMemory& memory) {
  return *std::launder(reinterpret_cast<detail::VideoMiddle*>(memory.get()));
}

bool read_whole(int file, std::size_t at, std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t got = ::pread(file, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(got));
    at += static_cast<std::size_t>(got);
  }
  return true;
}

}  // namespace

Result<FrameWriter> FrameWriter::open(int memory) {
  auto mapped = map(memory, kMemoryBytes);
  if (!mapped) return mapped.error();
  return FrameWriter(std::move(*mapped));
}

std::span<std::byte> FrameWriter::room() {
  return {memory_.get() + begin_of(slot_) + kPage, kVideoFrameBytesMax};
}

void FrameWriter::publish(const VideoFrame& frame, std::size_t size) {
  const SlotHead head{
      .head = frame.head, .when = frame.when.time_since_epoch().count(), .size = size};
  std::memcpy(memory_.get() + begin_of(slot_), &head, sizeof head);
  const std::uint32_t before =
      middle_of(memory_).slot.exchange(slot_ | kNew, std::memory_order_acq_rel);
  slot_ = std::min(before & kSlotMask, kSlots - 1);
}

Result<FrameReader> FrameReader::create() {
  File file(::memfd_create("video", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!file || ::ftruncate(file.get(), static_cast<off_t>(kMemoryBytes)) != 0)
    return system_error("cannot create the memory of video frames");
  ::fcntl(file.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL);
  auto middle = map(file.get(), kPage);
  if (!middle) return middle.error();
  new (middle->get()) detail::VideoMiddle();
  return FrameReader(std::move(file), std::move(*middle));
}

Result<bool> FrameReader::take(VideoFrame& frame, std::vector<std::byte>& bytes) {
  std::atomic<std::uint32_t>& middle = middle_of(middle_).slot;
  if ((middle.load(std::memory_order_relaxed) & kNew) == 0) return false;
  slot_ = middle.exchange(slot_, std::memory_order_acq_rel) & kSlotMask;
  SlotHead head;
  if (slot_ >= kSlots ||
      !read_whole(file_.get(), begin_of(slot_), std::as_writable_bytes(std::span(&head, 1))))
    return Error(Errc::kMalformed, "the memory of video frames is damaged");
  if (head.size > kVideoFrameBytesMax)
    return Error(Errc::kTooBig, "a video frame of " + std::to_string(head.size) + " bytes");
  bytes.resize(head.size);
  if (!read_whole(file_.get(), begin_of(slot_) + kPage, bytes))
    return Error(Errc::kMalformed, "the memory of video frames is damaged");
  frame = {.head = head.head, .when = tims::Time(tims::Duration(head.when))};
  return true;
}

}  // namespace rack::device

// Frames of a video from one process to another, in shared memory: a triple buffer.
//
// The writer fills a slot and exchanges it for the one in the middle; the reader exchanges its own
// slot for the one in the middle if that is new. So neither waits for the other, the reader gets
// the newest frame, and three frames are the most that is ever stored. The memory is a file without
// a name whose size is fixed when it is created.
//
// The writer decodes data of others, and is not trusted: the reader copies a frame before it is
// looked at, and checks its size.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "components/devices/core/video_frame.h"
#include "os/file.h"
#include "tims/result.h"
#include "tims/time.h"

namespace rack::device {

// 4096 * 3072 pixels of 24 bits.
inline constexpr std::size_t kVideoFrameBytesMax = std::size_t{4096} * 3072 * 3;

struct VideoFrame {
  VideoHead head{};
  tims::Time when{};
};

namespace detail {
struct VideoMiddle;  // what both share beside the slots
struct Unmap {
  std::size_t size = 0;
  void operator()(std::byte* begin) const;
};
using VideoMemory = std::unique_ptr<std::byte, Unmap>;
}  // namespace detail

class FrameWriter {
 public:
  // `memory`: a duplicate of FrameReader::memory().
  static tims::Result<FrameWriter> open(int memory);

  // For the next frame.
  [[nodiscard]] std::span<std::byte> room();
  // The first `size` bytes of room() are a frame.
  void publish(const VideoFrame& frame, std::size_t size);

 private:
  explicit FrameWriter(detail::VideoMemory memory) : memory_(std::move(memory)) {}

  detail::VideoMemory memory_;
  std::uint32_t slot_ = 0;
};

class FrameReader {
 public:
  static tims::Result<FrameReader> create();

  // To be inherited by the writer's process.
  [[nodiscard]] int memory() const { return file_.get(); }
  // Returns whether there is a frame that was not taken before. kMalformed: the writer is broken.
  tims::Result<bool> take(VideoFrame& frame, std::vector<std::byte>& bytes);

 private:
  FrameReader(tims::os::File file, detail::VideoMemory middle)
      : file_(std::move(file)), middle_(std::move(middle)) {}

  tims::os::File file_;
  detail::VideoMemory middle_;
  std::uint32_t slot_ = 2;
};

}  // namespace rack::device

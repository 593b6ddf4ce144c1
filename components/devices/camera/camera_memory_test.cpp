// A running camera allocates no memory where its pictures are passed on or converted. OpenCV
// allocates a little for each picture of JPEG that it decodes or encodes, and for each stereo pair.
#include <fstream>

#include <gtest/gtest.h>

#include "components/devices/camera/camera_frames.h"
#include "rack/devices/capture.h"
#include "tests/support/counted_new.h"

namespace rack::device {
namespace camera_memory_test {

using namespace std::chrono_literals;

struct Nobody : Output {
  void send(std::span<const std::byte>, std::uint32_t) override {}
};

std::vector<std::vector<std::byte>> jpegs() {
  std::ifstream file(DEVICE_DATA "/camera/donkeycar-20.cap");
  std::vector<std::vector<std::byte>> all;
  CaptureRecord record;
  for (std::string line; std::getline(file, line);)
    if (parse_record(line, record).value()) all.push_back(record.bytes);
  return all;
}

// Moving noise, which gives disparities in stereo pictures and varying sizes of JPEG.
std::vector<std::vector<std::byte>> noise(std::size_t bytes) {
  std::vector<std::vector<std::byte>> all(20, std::vector<std::byte>(bytes));
  std::uint32_t state = 1;
  for (auto& frame : all)
    for (std::byte& byte : frame)
      byte = static_cast<std::byte>((state = state * 1664525U + 1) >> 24);
  return all;
}

struct Case {
  const char* name;
  VideoHead head;
  u16 mode;
  std::size_t allocations_max = 0;  // of OpenCV, for each picture
};

void PrintTo(const Case& one, std::ostream* out) { *out << one.name; }

class CameraMemoryTest : public testing::TestWithParam<Case> {};

TEST_P(CameraMemoryTest, NoneIsTaken) {
  const auto& [name, head, mode, allocations_max] = GetParam();
  const auto frames =
      head.format == video::kMjpeg ? jpegs() : noise(std::size_t{head.line_bytes} * head.height);
  CameraFrames camera({.mode = mode, .focal = 100, .base = 60, .stereo = {.disparities = 16}});
  Nobody nobody;
  CameraData picture;
  picture.image.reserve_all();
  PictureMaker maker;
  CameraData small;
  small.image.reserve_all();
  const bool is_compressed = mode == camera_mode::kJpeg || allocations_max > 0;
  Time now{1000s};
  Time recorded;
  camera.start(now, nobody);
  const auto bytes = bytes_of(head);
  camera.on_arrival({.bytes = bytes, .first = now, .last = now, .id = video::kHead}, nobody);
  const auto turn = [&] {
    std::size_t taken = 0;
    for (const auto& frame : frames) {
      now += 33ms;
      camera.on_arrival({.bytes = frame, .first = now, .last = now, .id = head.format}, nobody);
      taken += camera.take(picture, recorded) ? 1 : 0;
      if (is_compressed && depth_of(mode) != 16) {
        EXPECT_TRUE(maker.compress(picture, small));
      }
    }
    EXPECT_EQ(taken, frames.size());
  };
  turn();  // warm-up: allocates all buffers
  const std::size_t before = tims::test::allocations();
  turn();
  EXPECT_LE(tims::test::allocations() - before, allocations_max * frames.size());
}

INSTANTIATE_TEST_SUITE_P(
    All, CameraMemoryTest,
    testing::Values(Case{"Passed", {.format = video::kMjpeg}, camera_mode::kJpeg},
                    Case{"Decoded", {.format = video::kMjpeg}, camera_mode::kRgb24, 9},
                    Case{"DecodedYuv", {.format = video::kMjpeg}, camera_mode::kYuv422, 5},
                    Case{"Compressed", {video::kYuyv, 64, 48, 128}, camera_mode::kJpeg, 6},
                    Case{"Grey", {video::kGrey, 64, 48, 64}, camera_mode::kMono8},
                    Case{"Grey16", {video::kGrey16, 64, 48, 128}, camera_mode::kMono16},
                    Case{"Colour", {video::kYuyv, 64, 48, 128}, camera_mode::kRgb24},
                    Case{"Depth", {video::kDepth16, 64, 48, 128}, camera_mode::kRange},
                    Case{"TwoEyes", {video::kGrey, 128, 48, 128}, camera_mode::kRange, 9},
                    Case{"Disparity", {video::kMjpeg}, camera_mode::kDisparity, 12}),
    [](const auto& one) { return std::string(one.param.name); });

}  // namespace camera_memory_test
}  // namespace rack::device

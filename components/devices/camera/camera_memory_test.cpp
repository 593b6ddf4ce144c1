// A running camera allocates no memory, for all formats and modes. (libjpeg allocates memory for
// each picture that it decodes; JPEG that is passed on is not decoded.)
#include <fstream>

#include <gtest/gtest.h>

#include "components/devices/camera/camera_frames.h"
#include "components/recordings/capture.h"
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
};

void PrintTo(const Case& one, std::ostream* out) { *out << one.name; }

class CameraMemoryTest : public testing::TestWithParam<Case> {};

TEST_P(CameraMemoryTest, NoneIsTaken) {
  const auto& [name, head, mode] = GetParam();
  const auto frames =
      head.format == video::kMjpeg ? jpegs() : noise(std::size_t{head.line_bytes} * head.height);
  CameraFrames camera({.mode = mode, .focal = 100, .base = 60, .stereo = {.disparities = 16}});
  Nobody nobody;
  CameraData picture;
  picture.image.reserve_all();
  PictureMaker maker;
  CameraData small;
  small.image.reserve_all();
  const bool can_be_small = mode == camera_mode::kMono8 || mode == camera_mode::kRgb24 ||
                            mode == camera_mode::kYuv422 || mode == camera_mode::kJpeg;
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
      if (can_be_small) {
        EXPECT_TRUE(maker.compress(picture, small));
      }
    }
    EXPECT_EQ(taken, frames.size());
  };
  turn();  // warm-up: allocates all buffers
  const std::size_t before = tims::test::allocations();
  turn();
  EXPECT_EQ(tims::test::allocations(), before);
}

INSTANTIATE_TEST_SUITE_P(
    All, CameraMemoryTest,
    testing::Values(Case{"Passed", {.format = video::kMjpeg}, camera_mode::kJpeg},
                    Case{"Decoded", {.format = video::kMjpeg}, camera_mode::kRgb24},
                    Case{"DecodedYuv", {.format = video::kMjpeg}, camera_mode::kYuv422},
                    Case{"Compressed", {video::kYuyv, 64, 48, 128}, camera_mode::kJpeg},
                    Case{"Grey", {video::kGrey, 64, 48, 64}, camera_mode::kMono8},
                    Case{"Grey16", {video::kGrey16, 64, 48, 128}, camera_mode::kMono16},
                    Case{"Colour", {video::kYuyv, 64, 48, 128}, camera_mode::kRgb24},
                    Case{"Depth", {video::kDepth16, 64, 48, 128}, camera_mode::kRange},
                    Case{"TwoEyes", {video::kGrey, 128, 48, 128}, camera_mode::kRange},
                    Case{"Disparity", {video::kMjpeg}, camera_mode::kDisparity}),
    [](const auto& one) { return std::string(one.param.name); });

}  // namespace camera_memory_test
}  // namespace rack::device

// The window for Camera of the original's GUI with our drivers. It requests the next picture,
// paints it, and sets either its mode or its size.
#include <cmath>
#include <fstream>

#include "components/devices/camera/picture.h"
#include "components/recordings/capture.h"
#include "rack/proxies/camera.h"
#include "tests/support/eventually.h"
#include "tests/system/modules_fixture.h"
#include "tests/system/original_window.h"

namespace tims::test {
namespace camera_window_test {

using rack::i16;
using rack::i32;
using rack::u16;
namespace camera_mode = rack::camera_mode;

struct Painted {
  int width = 0;
  int height = 0;
  int mode = 0;
  std::vector<std::byte> rgb;  // of its pixels; empty: nothing is painted
};

constexpr const char* kFrames = TIMS_TEST_DATA_DIR "/devices/camera/donkeycar-20.cap";

class CameraWindowTest : public ModulesTest {
 protected:
  void SetUp() override {
    ModulesTest::SetUp();
    gui_.emplace(router_.tcp());
  }
  Window open_window(std::uint32_t component) { return gui_->open_window(component); }

  static std::vector<std::byte> decoded(std::span<const std::byte> jpeg) {
    rack::device::PictureMaker maker;
    rack::CameraData picture;
    const auto made =
        maker.make({.format = rack::device::video::kMjpeg}, jpeg, camera_mode::kRgb24, picture);
    EXPECT_TRUE(made) << made.error().message();
    return painted_of_rgb24(picture.image);
  }
  // The window takes the first byte of a pixel as blue.
  static std::vector<std::byte> painted_of_rgb24(std::span<const std::byte> bytes) {
    std::vector<std::byte> rgb;
    for (std::size_t i = 0; i + 2 < bytes.size(); i += 3)
      rgb.insert(rgb.end(), {bytes[i + 2], bytes[i + 1], bytes[i]});
    return rgb;
  }

  // Paints like the window, which supports these modes (and two that no driver sends).
  static Painted paint(const OwnedMessage& message) {
    Fields fields(message);
    fields.next<i32>();
    Painted painted;
    painted.width = fields.next<i16>();
    painted.height = fields.next<i16>();
    fields.next<i16>();  // depth
    painted.mode = fields.next<i16>();
    const auto count = fields.next<i32>();  // number of bytes, or the filter
    const auto bytes = fields.rest();
    const auto pixels =
        static_cast<std::size_t>(painted.width) * static_cast<std::size_t>(painted.height);
    if (painted.mode == camera_mode::kJpeg) {
      EXPECT_EQ(bytes.size(), static_cast<std::size_t>(count));
      painted.rgb = decoded(bytes);
    } else if (painted.mode == camera_mode::kRgb24) {
      painted.rgb = painted_of_rgb24(bytes);
    } else if (painted.mode == camera_mode::kMono8) {
      for (const std::byte grey : bytes) painted.rgb.insert(painted.rgb.end(), 3, grey);
    } else if (painted.mode == camera_mode::kYuv422) {
      EXPECT_EQ(bytes.size(), pixels * 2);
      for (std::size_t i = 0; i + 3 < bytes.size(); i += 4)
        for (const std::size_t y : {i + 1, i + 3}) add_rgb(painted.rgb, bytes, i, y);
    }
    EXPECT_EQ(painted.rgb.size(), pixels * 3);
    return painted;
  }

  // U Y V Y, with footroom (BT.601).
  static void add_rgb(std::vector<std::byte>& rgb, std::span<const std::byte> bytes, std::size_t u,
                      std::size_t y) {
    const double luma = 1.164 * (std::to_integer<int>(bytes[y]) - 16);
    const int blue = std::to_integer<int>(bytes[u]) - 128;
    const int red = std::to_integer<int>(bytes[u + 2]) - 128;
    for (const double value :
         {luma + 1.596 * red, luma - 0.392 * blue - 0.813 * red, luma + 2.017 * blue})
      rgb.push_back(static_cast<std::byte>(std::clamp(value, 0.0, 255.0)));
  }

  Painted next_picture(Window& window) {
    const auto message = window.ask(type::kGetNextData);
    if (!message || message->header.type != type::kData) return {};
    return paint(*message);
  }
  // The message of its selection boxes; fields that are not selected are -1.
  int choose(Window& window, i32 width, i32 height, i32 depth, i32 mode) {
    return window.answer_to(rack::CameraType::kSetFormat, Body().add(width, height, depth, mode));
  }

  // The distance of the painted picture from the nearest frame of the recording: mean over all
  // colours; for grey pictures, compared with green, which is close to the luminance.
  double distance_to_recording(const Painted& painted) {
    if (recorded_.empty()) read_recording();
    double best = 255;
    const std::size_t step = painted.mode == camera_mode::kMono8 ? 3 : 1;
    for (const auto& frame : recorded_) {
      if (frame.size() != painted.rgb.size()) continue;
      double sum = 0;
      for (std::size_t i = step == 3 ? 1 : 0; i < frame.size(); i += step)
        sum += std::abs(std::to_integer<int>(frame[i]) - std::to_integer<int>(painted.rgb[i]));
      best = std::min(best, sum * static_cast<double>(step) / static_cast<double>(frame.size()));
    }
    return best;
  }

 private:
  void read_recording() {
    std::ifstream file(kFrames);
    rack::device::CaptureRecord record;
    for (std::string line; std::getline(file, line);)
      if (rack::device::parse_record(line, record).value())
        recorded_.push_back(decoded(record.bytes));
  }

  std::optional<OriginalGui> gui_;
  std::vector<std::vector<std::byte>> recorded_;
};

TEST_F(CameraWindowTest, PaintsEachModeOfItsBox) {
  start("CameraV4l", {std::string("--device=play:") + kFrames + "?loop=1", "--mode=jpeg"});
  Window window = open_window(0x00150000);
  window.press_on();
  const Painted first = next_picture(window);
  EXPECT_EQ(first.mode, camera_mode::kJpeg);
  EXPECT_EQ(first.width, 160);
  EXPECT_EQ(distance_to_recording(first), 0);
  EXPECT_TRUE(eventually([&] { return next_picture(window).rgb != first.rgb; }, "another picture"));
  struct Mode {
    u16 mode;
    i32 depth;
    double exactness;
  };
  for (const Mode& one : {Mode{camera_mode::kMono8, 8, 25}, Mode{camera_mode::kRgb24, 24, 0.1},
                          Mode{camera_mode::kYuv422, 16, 25}}) {
    EXPECT_EQ(choose(window, -1, -1, one.depth, one.mode), type::kOk) << one.mode;
    Painted painted;
    ASSERT_TRUE(eventually([&] { return (painted = next_picture(window)).mode == one.mode; },
                           "the mode " + std::to_string(one.mode)));
    EXPECT_LE(distance_to_recording(painted), one.exactness) << one.mode;
  }
  // Setting the size keeps the mode; a mode that the frames cannot be converted to is refused, and
  // painting continues.
  EXPECT_EQ(choose(window, 640, 480, -1, -1), type::kOk);
  EXPECT_EQ(choose(window, -1, -1, 16, camera_mode::kRgb565), type::kError);
  EXPECT_EQ(next_picture(window).mode, camera_mode::kYuv422);
}

TEST_F(CameraWindowTest, PaintsPicturesOfCameraJpeg) {
  start("CameraV4l", {std::string("--device=play:") + kFrames + "?loop=1", "--mode=rgb24"});
  start("CameraJpeg", {"--instance=1", "--cameraInst=0", "--quality=90"});
  Window window = open_window(0x00150100);
  window.press_on();
  const Painted painted = next_picture(window);
  EXPECT_EQ(painted.mode, camera_mode::kJpeg);
  EXPECT_LE(distance_to_recording(painted), 6);
}

}  // namespace camera_window_test
}  // namespace tims::test

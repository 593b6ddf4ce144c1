#include "components/devices/camera/exposure_control.h"

#include <map>

#include <gtest/gtest.h>

namespace rack::device {
namespace exposure_control_test {

using pictures::PixelLayout;

class ExposureControlTest : public testing::Test, public Output {
 public:
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    sent_[id] = *control_value(bytes);
  }

 protected:
  void report(ExposureControl& control, int shutter, int gain) {
    control.start();
    control.on_control({video::kAutoGain, 0, 1, 1}, *this);
    control.on_control({video::kShutter, 1, 4095, shutter}, *this);
    control.on_control({video::kGain, 192, 1023, gain}, *this);
  }
  // Lines of grey: the first ones, and the last ones.
  void show(ExposureControl& control, int upper, int lower) {
    std::vector<std::byte> grey(std::size_t{16} * 16, static_cast<std::byte>(upper));
    std::fill(grey.begin() + 128, grey.end(), static_cast<std::byte>(lower));
    control.on_frame({.size = {16, 16}, .bytes = grey}, *this);
  }
  int sent(std::uint32_t id) {
    const auto found = sent_.find(id);
    const int value = found == sent_.end() ? -1 : found->second;
    sent_.erase(id);
    return value;
  }

  std::map<std::uint32_t, int> sent_;
};

TEST_F(ExposureControlTest, TheShutterIsOpenedFirstAndTheGainReducedFirst) {
  ExposureControl control({});
  report(control, 4000, 192);
  EXPECT_EQ(sent(video::kAutoGain), 0);
  show(control, 60, 60);  // all dark
  EXPECT_EQ(sent(video::kShutter), 4064);
  show(control, 0, 0);
  EXPECT_EQ(sent(video::kShutter), 4095);
  show(control, 0, 100);  // half of it
  EXPECT_EQ(sent(video::kGain), 200);
  EXPECT_EQ(sent(video::kShutter), -1);
  show(control, 250, 250);  // all bright
  EXPECT_EQ(sent(video::kGain), 192);
  show(control, 255, 255);
  EXPECT_EQ(sent(video::kShutter), 4031);
  EXPECT_EQ(sent(video::kGain), -1);
}

TEST_F(ExposureControlTest, AGoodPictureChangesNothing) {
  ExposureControl control({});
  report(control, 1000, 300);
  sent_.clear();
  show(control, 61, 249);
  show(control, 60, 250);  // as much dark as bright
  EXPECT_TRUE(sent_.empty());
}

TEST_F(ExposureControlTest, TheLowestLinesAreEvaluated) {
  ExposureControl control({.part = 2});
  report(control, 1000, 192);
  show(control, 0, 100);
  EXPECT_EQ(sent(video::kShutter), -1);
  show(control, 100, 0);
  EXPECT_EQ(sent(video::kShutter), 1064);
}

TEST_F(ExposureControlTest, WithoutControlItIsTheCamerasOrFixed) {
  ExposureControl automatic({.part = 0});
  report(automatic, 1000, 192);
  EXPECT_EQ(sent(video::kAutoGain), 1);
  EXPECT_TRUE(sent_.empty());
  show(automatic, 0, 0);
  EXPECT_TRUE(sent_.empty());
  ExposureControl fixed({.part = 0, .shutter = 77, .gain = 5000});
  report(fixed, 1000, 192);
  EXPECT_EQ(sent(video::kAutoGain), 0);
  EXPECT_EQ(sent(video::kShutter), 77);
  EXPECT_EQ(sent(video::kGain), 1023);  // its maximum
}

TEST_F(ExposureControlTest, ACameraWithOneOfTheControlsIsControlledByThat) {
  ExposureControl control({});
  control.start();
  control.on_control({video::kGain, 0, 100, 50}, *this);
  show(control, 0, 0);
  EXPECT_EQ(sent(video::kGain), 66);
  control.start();
  control.on_control({video::kShutter, 0, 100, 100}, *this);
  show(control, 0, 0);
  EXPECT_TRUE(sent_.empty());
  control.start();
  show(control, 0, 0);
  EXPECT_TRUE(sent_.empty());
}

TEST_F(ExposureControlTest, LumaAndGreenCountButNotNumbersOf16Bits) {
  ExposureControl control({});
  report(control, 1000, 192);
  std::vector<std::byte> pixels(std::size_t{16} * 4 * 2);
  for (std::size_t i = 1; i < pixels.size(); i += 2) pixels[i] = std::byte{128};  // luma of UYVY
  control.on_frame({.layout = PixelLayout::kUyvy, .size = {16, 4}, .bytes = pixels}, *this);
  control.on_frame({.layout = PixelLayout::kBig16, .size = {16, 4}, .bytes = pixels}, *this);
  EXPECT_EQ(sent(video::kShutter), -1);
  control.on_frame({.layout = PixelLayout::kYuyv, .size = {16, 4}, .bytes = pixels}, *this);
  EXPECT_EQ(sent(video::kShutter), 1064);
}

}  // namespace exposure_control_test
}  // namespace rack::device

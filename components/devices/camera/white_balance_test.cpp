#include "components/devices/camera/white_balance.h"

#include <map>

#include <gtest/gtest.h>

namespace rack::device {
namespace white_balance_test {

using pictures::PixelLayout;

class WhiteBalanceTest : public testing::Test, public Output {
 public:
  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    sent_[id] = *control_value(bytes);
  }

 protected:
  void report(WhiteBalanceControl& control) {
    control.start();
    control.on_control({video::kAutoWhiteBalance, 0, 1, 1}, *this);
    control.on_control({video::kBlueBalance, 1, 255, 80}, *this);
    control.on_control({video::kRedBalance, 1, 255, 80}, *this);
  }
  // UYVY with a surface of these colour differences, and others around it.
  void show(WhiteBalanceControl& control, int u, int v, std::uint32_t width = 64) {
    std::vector<std::byte> pixels(std::size_t{2} * width * 32, std::byte{7});
    for (std::size_t y = 1; y < 11; ++y)
      for (std::size_t x = width / 2 - 20; x < width / 2 + 20; x += 2) {
        pixels[2 * (y * width + x)] = static_cast<std::byte>(u);
        pixels[2 * (y * width + x) + 2] = static_cast<std::byte>(v);
      }
    control.on_frame({.layout = PixelLayout::kUyvy, .size = {width, 32}, .bytes = pixels}, *this);
  }

  std::map<std::uint32_t, int> sent_;
};

TEST_F(WhiteBalanceTest, TheSurfaceBecomesGrey) {
  WhiteBalanceControl control({});
  report(control);
  EXPECT_EQ(sent_[video::kAutoWhiteBalance], 0);
  EXPECT_EQ(sent_[video::kBlueBalance], 150);
  EXPECT_EQ(sent_[video::kRedBalance], 120);
  show(control, 138, 108);
  EXPECT_EQ(sent_[video::kBlueBalance], 145);
  EXPECT_EQ(sent_[video::kRedBalance], 130);
  sent_.clear();
  show(control, 128, 128);
  EXPECT_TRUE(sent_.empty());
  for (int i = 0; i < 10; ++i) show(control, 255, 0);
  EXPECT_EQ(sent_[video::kBlueBalance], 1);
  EXPECT_EQ(sent_[video::kRedBalance], 255);
}

TEST_F(WhiteBalanceTest, WithoutASurfaceItIsFixedOrTheCameras) {
  WhiteBalanceControl fixed({.method = WhiteBalance::kFixed, .blue = 1000});
  report(fixed);
  EXPECT_EQ(sent_[video::kBlueBalance], 255);
  sent_.clear();
  show(fixed, 200, 200);
  EXPECT_TRUE(sent_.empty());
  WhiteBalanceControl automatic({.method = WhiteBalance::kByCamera});
  report(automatic);
  EXPECT_EQ(sent_[video::kAutoWhiteBalance], 1);
  EXPECT_EQ(sent_.size(), 1U);
}

TEST_F(WhiteBalanceTest, ASurfaceThatIsNotInThePictureIsNotEvaluated) {
  WhiteBalanceControl control({.columns = 33});
  report(control);
  sent_.clear();
  show(control, 200, 200);
  WhiteBalanceControl empty({.columns = 0});
  report(empty);
  sent_.clear();
  show(empty, 200, 200);
  WhiteBalanceControl low({.lines = 32});
  report(low);
  sent_.clear();
  show(low, 200, 200);
  EXPECT_TRUE(sent_.empty());
}

}  // namespace white_balance_test
}  // namespace rack::device

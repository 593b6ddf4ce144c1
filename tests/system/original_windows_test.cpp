// The windows for Gps, Gyro and Compass of the original's GUI with our drivers.
#include <cmath>
#include <numbers>

#include "tests/support/eventually.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/modules_fixture.h"
#include "tests/system/original_window.h"

namespace tims::test {
namespace original_windows_test {

using rack::i32;

class OriginalWindowsTest : public ModulesTest {
 protected:
  void SetUp() override {
    ModulesTest::SetUp();
    gui_.emplace(router_.tcp());
  }
  Window open_window(std::uint32_t component) { return gui_->open_window(component); }
  // Starts an emulated device at a terminal; returns its address for the driver.
  std::string emulate(const std::string& name) {
    const std::string path = folder_.path() / name;
    devices_.push_back(ModulesTest::emulate(name, "pty:" + path));
    return "--device=serial:" + path;
  }

  std::optional<OriginalGui> gui_;

 private:
  TemporaryFolder folder_;
  std::vector<ChildProcess> devices_;
};

TEST_F(OriginalWindowsTest, GpsShowsThePosition) {
  start("GpsNmea", {emulate("nmea"), "--positionInst=-1"});
  Window window = open_window(0x00160000);
  EXPECT_FALSE(window.poll()) << "it is off";
  window.press_on();
  struct Shown {
    i32 mode, altitude, speed, satellites;
    double latitude, longitude;
    std::int64_t utc;
  } shown{};
  const auto look = [&] {
    const auto message = window.poll();
    if (!message) return false;
    EXPECT_EQ(message->body.size(), 100U);
    Fields fields(*message);
    fields.next<i32>();  // recordingTime
    shown.mode = fields.next<i32>();
    shown.latitude = fields.next<double>() * 180 / std::numbers::pi;
    shown.longitude = fields.next<double>() * 180 / std::numbers::pi;
    shown.altitude = fields.next<i32>();
    fields.next<float>();  // heading
    shown.speed = fields.next<i32>();
    shown.satellites = fields.next<i32>();
    shown.utc = fields.next<std::int64_t>();
    return true;
  };
  ASSERT_TRUE(eventually([&] { return look() && shown.mode == 2; }, "a fix in three dimensions"));
  EXPECT_NEAR(shown.latitude, 52.382, 0.001);
  EXPECT_NEAR(shown.longitude, 9.717, 0.001);
  EXPECT_NEAR(shown.altitude, 60'000, 10'100);
  EXPECT_NEAR(shown.speed, 2000, 20);
  EXPECT_GE(shown.satellites, 8);
  const Shown before = shown;
  ASSERT_TRUE(eventually([&] { return look() && shown.utc > before.utc; }, "a second later"));
  EXPECT_TRUE(shown.latitude != before.latitude || shown.longitude != before.longitude);
  EXPECT_EQ(window.answer_to(type::kOff), type::kOk);
  EXPECT_TRUE(eventually([&] { return !window.poll(); }, "no values"));
}

TEST_F(OriginalWindowsTest, GyroShowsAnglesAndRates) {
  start("GyroXsens", {emulate("xsens")});
  Window window = open_window(0x001E0000);
  window.press_on();
  std::array<float, 9> shown{};  // roll pitch yaw, acceleration, rates
  const auto look = [&] {
    const auto message = window.poll();
    if (!message) return false;
    EXPECT_EQ(message->body.size(), 40U);
    Fields fields(*message);
    fields.next<i32>();
    for (float& value : shown) value = fields.next<float>();
    return true;
  };
  ASSERT_TRUE(eventually(look, "values"));
  EXPECT_NEAR(std::abs(shown[5]), 9810, 50);   // gravity, mm/s2
  EXPECT_NEAR(std::abs(shown[8]), 0.2, 0.01);  // rate of turn, rad/s
  EXPECT_NEAR(shown[1], 0, 0.01);
  const float yaw = shown[2];
  EXPECT_TRUE(eventually([&] { return look() && std::abs(shown[2] - yaw) > 0.05; }, "it turned"));
}

TEST_F(OriginalWindowsTest, CompassShowsTheHeading) {
  start("CompassCmps03", {emulate("cmps03")});
  Window window = open_window(0x00280000);
  window.press_on();
  float orientation = -1;
  const auto look = [&] {
    const auto message = window.poll();
    if (!message) return false;
    EXPECT_EQ(message->body.size(), 12U);
    Fields fields(*message);
    fields.next<i32>();
    orientation = fields.next<float>();
    return true;
  };
  ASSERT_TRUE(eventually(look, "a value"));
  const float before = orientation;
  EXPECT_TRUE(eventually([&] { return look() && orientation > before + 0.2; }, "15 deg a second"));
}

}  // namespace original_windows_test
}  // namespace tims::test

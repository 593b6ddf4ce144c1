// A device at its line, pulled out and plugged in.
#include "components/world/plugged_device.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "components/devices/chassis/pioneer.h"
#include "os/clock.h"
#include "tests/support/temporary_folder.h"

namespace rack::device {
namespace plugged_device_test {

using namespace std::chrono_literals;

// Sends a text at its start, and requests timeouts repeatedly.
class Ticking final : public Dialogue {
 public:
  void start(Time now, Output&) override {
    ++starts;
    next_ = now + 1ms;
  }
  void on_arrival(const Arrival&, Output&) override {}
  void on_timeout(Time now, Output& out) override {
    ++ticks;
    next_ = now + 1ms;
    out.send(std::array{std::byte{1}});
  }
  [[nodiscard]] Time next_timeout() const override { return next_; }

  int starts = 0;
  int ticks = 0;

 private:
  Time next_ = tims::kNever;
};

class PluggedDeviceTest : public testing::Test {
 protected:
  PluggedDeviceTest()
      : device_("scout/base", *DeviceAddress::parse("pty:" + path_), 9600, make()) {}
  std::unique_ptr<Dialogue> make() {
    auto made = std::make_unique<Ticking>();
    ticking_ = made.get();
    return made;
  }
  // Until it has ticked so often.
  void serve(int ticks) {
    for (const Time end = tims::os::now() + 20s;
         ticking_->ticks < ticks && tims::os::now() < end;) {
      EXPECT_FALSE(device_.serve(std::max(tims::os::now(), device_.next_timeout())));
    }
    EXPECT_GE(ticking_->ticks, ticks);
  }
  [[nodiscard]] bool has_line() const { return ::access(path_.c_str(), F_OK) == 0; }

  tims::test::TemporaryFolder folder_;
  const std::string path_ = folder_.path() / "line";
  Ticking* ticking_ = nullptr;
  PluggedDevice device_;
};

TEST_F(PluggedDeviceTest, ItsLineIsThereWhileItIsPlugged) {
  EXPECT_FALSE(has_line());
  ASSERT_TRUE(device_.plug());
  EXPECT_TRUE(has_line());
  EXPECT_GE(device_.descriptor(), 0);
  serve(3);
  device_.pull();
  EXPECT_FALSE(has_line());
  EXPECT_EQ(device_.descriptor(), -1);
  ASSERT_TRUE(device_.plug());
  EXPECT_TRUE(has_line());
  EXPECT_EQ(ticking_->starts, 2) << "switched on with its line";
  ASSERT_TRUE(device_.plug());
  EXPECT_EQ(ticking_->starts, 2) << "it was plugged in";
}

// Its watchdog, for example.
TEST_F(PluggedDeviceTest, ItLivesOnWhenItIsPulledOut) {
  ASSERT_TRUE(device_.plug());
  serve(2);
  device_.pull();
  serve(ticking_->ticks + 3);
}

TEST_F(PluggedDeviceTest, ALineThatCannotBeMadeIsReported) {
  PluggedDevice lost("scout/base", *DeviceAddress::parse("pty:/no/such/folder/line"), 9600, make());
  const auto plugged = lost.plug();
  ASSERT_FALSE(plugged);
  EXPECT_NE(plugged.error().message().find("/no/such/folder"), std::string::npos);
  EXPECT_FALSE(lost.is_plugged());
}

}  // namespace plugged_device_test
}  // namespace rack::device

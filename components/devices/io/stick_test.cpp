// A joystick created with the kernel's uinput: it is listed and can be read. Skipped without
// uinput: `tools/dev vm-test` has it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/joystick.h>
#include <unistd.h>

#include "components/devices/io/host_devices.h"
#include "os/file.h"
#include "tests/support/eventually.h"
#include "tests/support/uinput_stick.h"

namespace rack::device {
namespace stick_test {

using tims::os::File;
using tims::test::eventually;

constexpr const char* kName = "RACK test stick";

class StickTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!stick_.is_plugged_in()) GTEST_SKIP() << "no uinput: tools/dev vm-test";
    ASSERT_TRUE(eventually([] { return found() && found()->may_use; }, "the stick is there"));
  }
  static std::optional<HostDevice> found() {
    for (const HostDevice& device : host_devices())
      if (device.is_stick && device.text == kName) return device;
    return std::nullopt;
  }

  tims::test::UinputStick stick_{kName};
};

TEST_F(StickTest, IsListedAndGoesWithItsDevice) {
  EXPECT_EQ(programs_text(*found()), "Joystick");
  EXPECT_TRUE(device_address(*found()).starts_with("/dev/input/js"));
  stick_.pull_out();
  EXPECT_TRUE(eventually([] { return !found(); }, "it is gone"));
}

TEST_F(StickTest, ItsEventsCanBeRead) {
  const File file(::open(found()->path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  ASSERT_TRUE(file);
  ASSERT_TRUE(stick_.move(ABS_X, tims::test::UinputStick::kEnd));
  js_event last{};
  EXPECT_TRUE(eventually(
      [&] {
        js_event event{};
        while (::read(file.get(), &event, sizeof event) == static_cast<ssize_t>(sizeof event))
          if ((event.type & ~JS_EVENT_INIT) == JS_EVENT_AXIS && event.number == 0) last = event;
        return last.value == 32767;
      },
      "the stick was pushed to its end"));
}

TEST_F(StickTest, UnpluggingIsReported) {
  const auto before = host_devices();
  stick_.pull_out();
  std::vector<DeviceChange> changed;
  EXPECT_TRUE(eventually(
      [&] {
        changed = changes(before, host_devices());
        return !changed.empty();
      },
      "a change"));
  ASSERT_FALSE(changed.empty());
  EXPECT_FALSE(changed[0].is_there);
  EXPECT_EQ(changed[0].device.text, kName);
}

}  // namespace stick_test
}  // namespace rack::device

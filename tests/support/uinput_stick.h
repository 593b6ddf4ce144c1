// A joystick emulated by the kernel's uinput, with two axes and a button. It is removed with the
// object.
#pragma once

#include <array>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <linux/uinput.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "os/file.h"

namespace tims::test {

class UinputStick {
 public:
  // Without uinput it is not plugged in; tools/dev vm-test has uinput.
  explicit UinputStick(const std::string& name)
      : file_(::open("/dev/uinput", O_WRONLY | O_NONBLOCK | O_CLOEXEC)) {
    uinput_setup setup{};
    name.copy(setup.name, sizeof setup.name - 1);
    setup.id = {.bustype = BUS_USB, .vendor = 1, .product = 2, .version = 3};
    uinput_abs_setup axis{};
    axis.absinfo.minimum = -kEnd;
    axis.absinfo.maximum = kEnd;
    bool good = file_ && set(UI_SET_EVBIT, EV_KEY) && set(UI_SET_KEYBIT, BTN_TRIGGER) &&
                set(UI_SET_EVBIT, EV_ABS);
    for (const int code : {ABS_X, ABS_Y}) {
      axis.code = static_cast<__u16>(code);
      good = good && set(UI_SET_ABSBIT, code) && ::ioctl(file_.get(), UI_ABS_SETUP, &axis) == 0;
    }
    good = good && ::ioctl(file_.get(), UI_DEV_SETUP, &setup) == 0 &&
           ::ioctl(file_.get(), UI_DEV_CREATE) == 0;
    if (!good) file_.reset();
  }

  [[nodiscard]] bool is_plugged_in() const { return static_cast<bool>(file_); }
  void pull_out() { file_.reset(); }

  static constexpr int kEnd = 100;  // largest value of an axis in both directions
  // `axis`: ABS_X, ABS_Y.
  bool move(int axis, int value) const { return write_event(EV_ABS, axis, value); }
  bool press(bool down) const { return write_event(EV_KEY, BTN_TRIGGER, down ? 1 : 0); }

 private:
  [[nodiscard]] bool set(unsigned long what, int value) const {
    return ::ioctl(file_.get(), what, value) == 0;
  }
  [[nodiscard]] bool write_event(int type, int code, int value) const {
    std::array<input_event, 2> events{};
    events[0].type = static_cast<__u16>(type);
    events[0].code = static_cast<__u16>(code);
    events[0].value = value;
    events[1].type = EV_SYN;
    return ::write(file_.get(), events.data(), sizeof events) ==
           static_cast<ssize_t>(sizeof events);
  }

  os::File file_;
};

}  // namespace tims::test

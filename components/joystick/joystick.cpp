// Joystick: a joystick of this host, or the keyboard of its terminal.
#include <array>
#include <cerrno>
#include <optional>

#include <fcntl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include "components/joystick/sticks.h"
#include "os/file.h"
#include "rack/clock.h"
#include "rack/data_module.h"

namespace rack::joystick {
namespace {

constexpr std::array<ParameterInfo, 6> kParameters = {{
    host_file(
        {"device", "/dev/input/js0", "joystick device, or a pipe of its events; -: the keyboard"}),
    {"axisX", 1, "axis of the device for backward and forward; -1: none", -1, 255},
    {"axisY", 0, "axis of the device for left and right; -1: none", -1, 255},
    {"axisZ", 2, "third axis of the device; -1: none", -1, 255},
    {"deadZone", 5, "dead zone around the centre [%]", 0, 100},
    {"periodTime", 100, "period of the data [ms]", 1, 1000},
}};

constexpr ModuleInfo kInfo{
    .program = "Joystick",
    .purpose =
        "A joystick of this host, or the keyboard of its terminal: w a s d or arrows move "
        "the stick, digits are buttons, any other key releases it.",
    .class_id = tims::class_id::kJoystick,
    .parameters = kParameters,
};

using tims::os::system_error;

// Switches the terminal to raw mode, with keys passed immediately, while it exists.
class RawTerminal {
 public:
  RawTerminal() : good_(::tcgetattr(STDIN_FILENO, &before_) == 0) {
    if (!good_) return;
    termios raw = before_;
    raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    raw.c_cc[VMIN] = 0;
    raw.c_cc[VTIME] = 0;
    ::tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  }
  RawTerminal(const RawTerminal&) = delete;
  RawTerminal& operator=(const RawTerminal&) = delete;
  ~RawTerminal() {
    if (good_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  }
  [[nodiscard]] bool good() const { return good_; }

 private:
  termios before_{};
  bool good_;
};

class Joystick : public DataModule<JoystickData> {
 public:
  Joystick() : DataModule(kInfo, {.history = 10}) {}

 private:
  Result<void> module_on() override {
    set_period(std::chrono::milliseconds(integer("periodTime")));
    const std::string device = text("device");
    if (auto opened = device == "-" ? open_keyboard() : open_device(device); !opened) return opened;
    return DataModule::module_on();
  }

  Result<void> open_keyboard() {
    terminal_.emplace();
    if (!terminal_->good()) return system_error("stdin is not a terminal");
    keyboard_.emplace();
    return {};
  }

  Result<void> open_device(const std::string& path) {
    file_ = tims::os::File(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    if (!file_) return system_error(path);
    struct stat status {};
    is_pipe_ = ::fstat(file_.get(), &status) == 0 && S_ISFIFO(status.st_mode);
    events_.emplace(AxisMap{.x = integer("axisX"),
                            .y = integer("axisY"),
                            .z = integer("axisZ"),
                            .dead_zone = integer("deadZone")});
    return {};
  }

  void module_off() override {
    terminal_.reset();
    keyboard_.reset();
    events_.reset();
    file_ = {};
  }

  Result<void> module_loop() override {
    sleep_until_next(period());
    if (auto read = keyboard_ ? read_keyboard() : read_device(); !read) return read;
    JoystickData& data = get_local_buffer();
    data.recordingTime = time_stamp();
    data.position = keyboard_ ? keyboard_->position() : events_->position();
    data.buttons = keyboard_ ? keyboard_->buttons() : events_->buttons();
    return put_local_buffer();
  }

  Result<void> read_keyboard() {
    std::array<char, 64> keys{};
    for (;;) {
      const ssize_t size = ::read(STDIN_FILENO, keys.data(), keys.size());
      if (size < 0 && errno != EAGAIN && errno != EINTR) return system_error("stdin");
      if (size <= 0) return {};
      keyboard_->push({keys.data(), static_cast<std::size_t>(size)});
    }
  }

  Result<void> read_device() {
    std::array<std::byte, 512> bytes{};
    for (;;) {
      const ssize_t size = ::read(file_.get(), bytes.data(), bytes.size());
      if (size < 0)
        return errno == EAGAIN || errno == EINTR ? Result<void>() : system_error("joystick");
      if (size == 0) return ended();
      events_->push(std::span(bytes).first(static_cast<std::size_t>(size)));
    }
  }

  // The device is gone: releases the stick.
  Result<void> ended() {
    if (!is_pipe_) return tims::Error(tims::Errc::kSystem, "the joystick was unplugged");
    events_->release();
    return {};
  }

  tims::os::File file_;
  bool is_pipe_ = false;
  std::optional<JsEvents> events_;
  std::optional<RawTerminal> terminal_;
  std::optional<KeyboardStick> keyboard_;
};

}  // namespace
}  // namespace rack::joystick

int main(int argc, char** argv) {
  rack::joystick::Joystick joystick;
  return joystick.run(argc, argv);
}

// Base of all drivers: a component that publishes the data of a device dialogue.
//
//   class Gps : public Driver<GpsData, GpsDialogue> {
//     Result<DeviceOptions> device() const override;                    // by its parameters
//     Result<std::unique_ptr<GpsDialogue>> make_dialogue() override;    // also set_period()
//   };
//
// The dialogue provides `bool take(Data&, Time& recorded)`, which returns the next data set and its
// time of measurement, and `bool is_ready()`, which is true once the device sends data; from then
// on, three periods without data are an error. An error turns the component off, and on again after
// errorTimeout: this is how an unplugged device is used again. Optional members of a dialogue:
// broken(), the number of invalid telegrams, and serial_number(), to detect a replaced device.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>

#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/devices/device.h"
#include "rack/devices/recording.h"
#include "rack/devices/replay.h"
#include "rack/devices/wakeup.h"

namespace rack::device {

// --- parameters of all drivers

inline constexpr std::array<ParameterInfo, 4> kDriverParameters = {{
    host_file({"device", "",
               "address of the device, e.g. tcp:192.168.0.1:2112; see timsctl device list"}),
    host_file({"record", "", "record received and sent data in this file, for play: and replay"}),
    host_file(at_start(
        {"replay", "", "replay such a file without a router and compare the resulting data"})),
    {"errorTimeout", 500, "pause before a retry after an error [ms]", 0, 60000},
}};

// The common parameters followed by those of the driver.
template <std::size_t N>
constexpr auto driver_parameters(const std::array<ParameterInfo, N>& own) {
  return joined(kDriverParameters, own);
}

// The wall-clock time of a measurement, according to the current setting of the wall clock.
inline TimeStamp time_stamp_of(tims::Time measured, tims::Time now, TimeStamp wall) {
  return wall - std::chrono::duration_cast<std::chrono::milliseconds>(now - measured);
}
inline TimeStamp time_stamp_of(tims::Time measured) {
  return time_stamp_of(measured, now(), time_stamp());
}

template <class Data, class Dialog>
class Driver : public DataModule<Data> {
 public:
  using DataModule<Data>::DataModule;

 protected:
  virtual Result<DeviceOptions> device() const = 0;
  virtual Result<std::unique_ptr<Dialog>> make_dialogue() = 0;
  // Called before each wait to pass commands to the dialogue. Returns when to call it again.
  virtual tims::Time prepare(tims::Time /*now*/) { return tims::kNever; }
  // Causes a call of prepare(); may be called by any task.
  void wake() { woken_.signal(); }
  // Takes further results of the dialogue, for other components, before the next input.
  virtual void take_others() {}
  // Completes a data set before it is published.
  virtual Result<void> complete(Data& /*data*/) { return {}; }

  // The address given by parameter "device", or else by the original's parameter `numbered`.
  Result<DeviceOptions> device_by(std::string_view numbered,
                                  Result<DeviceAddress> (*by_number)(std::int32_t),
                                  std::uint32_t baud) const {
    DeviceOptions options{.baud = baud, .record = this->text("record")};
    const std::string address = this->text("device");
    const auto parsed =
        address.empty() ? by_number(this->integer(numbered)) : DeviceAddress::parse(address);
    if (!parsed) return parsed.error();
    options.address = *parsed;
    return options;
  }

  Result<void> module_init() override {
    if (auto opened = woken_.open(); !opened) return opened;
    return DataModule<Data>::module_init();
  }

  // Opens the device again with the current results of device() and make_dialogue().
  Result<void> open_device() {
    close_device();
    auto options = device();
    if (!options) return options.error();
    auto dialogue = make_dialogue();
    if (!dialogue) return dialogue.error();
    dialogue_ = std::move(*dialogue);
    if (!options->record.empty()) made_.resize(body_max<Data>());
    auto opened = Device::open(*options, *dialogue_, [this] { return take_all(); });
    if (!opened) return opened.error();
    device_ = std::move(*opened);
    last_received_ = now();
    has_reported_end_ = has_taken_ = is_known_ = false;
    return {};
  }

  Result<void> module_on() override {
    if (auto opened = open_device(); !opened) return opened;
    return DataModule<Data>::module_on();
  }

  void module_off() override {
    if (device_ && broken() > 0 && !has_reported_end_)
      this->log().warning("{}: {} invalid telegrams since it was opened", device_->description(),
                          broken());
    close_device();
    dialogue_.reset();
  }

  Result<void> module_loop() override {
    const tims::Time end = now() + kLongest;
    while (!std::exchange(has_taken_, false)) {
      woken_.drain();
      const tims::Time until = std::min(end, prepare(now()));
      if (auto waited = device_->wait(until, woken_.descriptor()); !waited) return waited;
      report_event();
      if (now() >= end && !has_taken_) return check_silence();
    }
    return {};
  }

  [[nodiscard]] Dialog& dialogue() { return *dialogue_; }
  // True if the device is a recording, which ignores output.
  [[nodiscard]] bool is_recording() const {
    const auto address = DeviceAddress::parse(this->text("device"));
    return address &&
           (address->kind == TransportKind::kPlayback || address->kind == TransportKind::kFile);
  }

 private:
  static constexpr tims::Duration kLongest = std::chrono::milliseconds(100);

  void close_device() {
    if (!device_) return;
    device_->close();
    report_event();
    device_.reset();
  }

  void report_event() {
    if (const auto event = device_->take_event()) this->log().warning("{}", *event);
  }

  // Publishes, and records if enabled, all data sets that the dialogue has ready.
  Result<void> take_all() {
    take_others();
    Data& data = this->get_local_buffer();
    for (tims::Time recorded{}; dialogue_->take(data, recorded);) {
      last_received_ = now();
      has_taken_ = true;
      if (!std::exchange(is_known_, true)) recognize();
      if (device_->is_recorded())
        if (const auto body = body_of(data); !body.empty()) device_->note_made(recorded, body);
      data.recordingTime = time_stamp_of(recorded);
      if (auto completed = complete(data); !completed) return completed;
      if (auto put = this->put_local_buffer(); !put) return put;
    }
    return {};
  }

  // The encoded data of the device alone, without a wall-clock time. Empty if encoding fails.
  std::span<const std::byte> body_of(Data& data) {
    data.recordingTime = TimeStamp(0);
    const auto size = encode(data, std::span(made_));
    return std::span(made_).first(size ? *size : 0);
  }

  // Parameter "replay": processes a recording instead of a device.
  std::optional<Result<Module::Report>> run_alone() override {
    const std::string file = this->text("replay");
    if (file.empty()) return {};
    Data data;
    reserve_all(data);
    made_.resize(body_max<Data>());
    Replay replay([&]() -> Result<Replay::Side> {
      auto made = make_dialogue();
      if (!made) return made.error();
      dialogue_ = std::move(*made);
      return Replay::Side{.dialogue = dialogue_.get(), .take = [&]() -> Result<void> {
                            for (tims::Time recorded{}; dialogue_->take(data, recorded);)
                              if (const auto body = body_of(data); !body.empty())
                                replay.made(recorded, body);
                            return {};
                          }};
    });
    const auto read =
        read_recording(file, [&](const CaptureRecord& record) { return replay.take(record); });
    if (!read) return read.error();
    if (replay.openings() == 0)
      return this->refused(
          file + " does not state when a device was opened: it was not written by --record");
    return Module::Report{.code = replay.is_same() ? ExitCode::kGood : ExitCode::kFailed,
                          .text = replay.report()};
  }

  Result<void> check_silence() {
    if (device_->is_over() && !std::exchange(has_reported_end_, true)) report_end();
    // Pauses and the end of a recording are not errors.
    if (!dialogue_->is_ready() || device_->is_recording()) {
      last_received_ = now();
      return {};
    }
    const tims::Duration silence = now() - last_received_;
    if (silence < std::max<tims::Duration>(3 * this->period(), device_->pause_max())) return {};
    const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(silence);
    return tims::Error(tims::Errc::kTimeout, device_->description() + " has sent no data for " +
                                                 std::to_string(milliseconds.count()) + " ms");
  }

  void report_end() {
    this->log().print("{}: end of the recording, {} invalid telegrams", device_->description(),
                      broken());
    if (is_known_) return;
    std::string why = "it may be of another device, or at another rate";
    if constexpr (requires { dialogue_->why_silent(); }) why = dialogue_->why_silent();
    this->log().warning("{}: no data set was found in it: {}", device_->description(), why);
  }

  // A replaced device is used, but reported.
  void recognize() {
    if constexpr (requires { dialogue_->serial_number(); }) {
      std::string number = dialogue_->serial_number();
      if (number.empty() || number == serial_number_) return;
      if (serial_number_.empty())
        this->log().info("{} has the serial number {}", device_->description(), number);
      else
        this->log().warning("{} is a different device: serial number {}, before {}",
                            device_->description(), number, serial_number_);
      serial_number_ = std::move(number);
    }
  }

  // Number of invalid telegrams, for dialogues that count them.
  [[nodiscard]] std::int64_t broken() const {
    if constexpr (requires { dialogue_->broken(); })
      return static_cast<std::int64_t>(dialogue_->broken());
    return 0;
  }

  Wakeup woken_;
  std::unique_ptr<Dialog> dialogue_;
  std::unique_ptr<Device> device_;
  tims::Time last_received_{};
  bool has_reported_end_ = false;  // the end of a recording was reported
  bool has_taken_ = false;
  bool is_known_ = false;        // recognize() was called since the device was opened
  std::string serial_number_;    // of the last device since this program started
  std::vector<std::byte> made_;  // encoding buffer for recording and replay
};

}  // namespace rack::device

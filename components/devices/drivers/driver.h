// What every driver is: a component whose data come out of a dialogue with a device.
//
//   class Gps : public Driver<GpsData, GpsDialogue> {
//     Result<DeviceOptions> device() const override;                    // by its parameters
//     Result<std::unique_ptr<GpsDialogue>> make_dialogue() override;    // also set_period()
//   };
//
// The dialogue tells by `bool take(Data&, Time& recorded)` that there are data, and when they were
// measured; by `bool is_ready()` that data are to be expected: from then on three periods without
// any are an error. An error turns the component off, and on again after errorTimeout: that is how
// a device that was pulled out comes back. One that has broken() is asked how many telegrams were;
// one that has serial_number(), whether this is the device that it was before.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>

#include "components/devices/core/replay.h"
#include "components/devices/drivers/relay.h"
#include "components/devices/io/device.h"
#include "components/devices/io/recording.h"
#include "os/wakeup.h"
#include "rack/clock.h"
#include "rack/data_module.h"

namespace rack::device {

// --- parameters of all drivers

inline constexpr std::array<ParameterInfo, 4> kDriverParameters = {{
    {"device", "", "where the device is, as tcp:192.168.0.1:2112; see timsctl device list"},
    {"record", "", "file that what comes and goes is recorded in, for play: and replay"},
    at_start({"replay", "",
              "such a file, made data of again at once, without a router: are they the same?"}),
    {"errorTimeout", 500, "after an error it is tried again, ms", 0, 60000},
}};

// Those and the driver's own.
template <std::size_t N>
constexpr auto driver_parameters(const std::array<ParameterInfo, N>& own) {
  return joined(kDriverParameters, own);
}

// The wall-clock time of what was measured then: by the clock on the wall as it is set now.
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
  // Before each wait: what the dialogue shall do next. Returns when it wants to be asked again.
  virtual tims::Time prepare(tims::Time /*now*/) { return tims::kNever; }
  // Any task: prepare() is called now.
  void wake() {
    if (woken_) tims::os::signal_event_fd(woken_.get());
  }
  // What the dialogue has for others, before the next piece comes from the device.
  virtual void take_others() {}
  // Of data that were just taken, before they are sent.
  virtual Result<void> complete(Data& /*data*/) { return {}; }

  // "device", or else what the original called `numbered`.
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

  // At the component that NAMESys and NAMEInst say; -1: at none.
  template <class Other>
  void aim(Relay<Other>& relay, tims::Mailbox& work, std::uint32_t class_id,
           const std::string& name) const {
    relay.stop();
    if (this->integer(name + "Inst") >= 0) relay.aim(work, this->address_of(class_id, name));
  }

  Result<void> module_init() override {
    auto woken = tims::os::make_event_fd();
    if (!woken) return woken.error();
    woken_ = std::move(*woken);
    return DataModule<Data>::module_init();
  }

  // Anew, with what device() and make_dialogue() say now.
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
    heard_ = now();
    has_told_end_ = has_taken_ = is_known_ = false;
    return {};
  }

  Result<void> module_on() override {
    if (auto opened = open_device(); !opened) return opened;
    return DataModule<Data>::module_on();
  }

  void module_off() override {
    if (device_ && broken() > 0 && !has_told_end_)
      this->log().warning("%s: %d telegrams were broken since it was opened",
                          device_->description(), broken());
    close_device();
    dialogue_.reset();
  }

  Result<void> module_loop() override {
    const tims::Time end = now() + kLongest;
    while (!std::exchange(has_taken_, false)) {
      tims::os::drain_event_fd(woken_.get());
      const tims::Time until = std::min(end, prepare(now()));
      if (auto waited = device_->wait(until, woken_.get()); !waited) return waited;
      tell_event();
      if (now() >= end && !has_taken_) return check_silence();
    }
    return {};
  }

  [[nodiscard]] Dialog& dialogue() { return *dialogue_; }
  // Nobody hears what is sent to this device.
  [[nodiscard]] bool is_recording() const {
    const auto address = DeviceAddress::parse(this->text("device"));
    return address && address->kind == TransportKind::kPlayback;
  }

 private:
  static constexpr tims::Duration kLongest = std::chrono::milliseconds(100);
  static constexpr tims::Duration kSilenceMin = std::chrono::milliseconds(200);

  void close_device() {
    if (!device_) return;
    device_->close();
    tell_event();
    device_.reset();
  }

  void tell_event() {
    if (const auto event = device_->take_event()) this->log().warning("%s", *event);
  }

  // All that the dialogue has ready is kept and sent.
  Result<void> take_all() {
    take_others();
    Data& data = this->get_local_buffer();
    for (tims::Time recorded{}; dialogue_->take(data, recorded);) {
      heard_ = now();
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

  // As the device said it: nobody has added anything yet. Empty: it is none that can be sent.
  std::span<const std::byte> body_of(Data& data) {
    data.recordingTime = TimeStamp(0);
    const auto size = encode(data, std::span(made_));
    return std::span(made_).first(size ? *size : 0);
  }

  // "replay": what this program makes now of what a device said then.
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
      return this->refused(file + " does not say when a device was opened: it is none of --record");
    return Module::Report{.code = replay.is_same() ? ExitCode::kGood : ExitCode::kFailed,
                          .text = replay.report()};
  }

  Result<void> check_silence() {
    if (device_->is_over() && !std::exchange(has_told_end_, true))
      this->log().print("%s is over: %d telegrams were broken", device_->description(), broken());
    // A recording has the pauses that it has, and an end.
    if (!dialogue_->is_ready() || device_->is_recording()) {
      heard_ = now();
      return {};
    }
    const tims::Duration silence = now() - heard_;
    if (silence < std::max<tims::Duration>(3 * this->period(), kSilenceMin)) return {};
    const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(silence);
    return tims::Error(tims::Errc::kTimeout, device_->description() + " sends nothing, for " +
                                                 std::to_string(milliseconds.count()) + " ms");
  }

  // Whoever is plugged in instead of another one is used, but that is said.
  void recognize() {
    if constexpr (requires { dialogue_->serial_number(); }) {
      std::string number = dialogue_->serial_number();
      if (number.empty() || number == serial_number_) return;
      if (serial_number_.empty())
        this->log().info("%s has the serial number %s", device_->description(), number);
      else
        this->log().warning("%s is another device than before: serial number %s, not %s",
                            device_->description(), number, serial_number_);
      serial_number_ = std::move(number);
    }
  }

  // Of dialogues that count what was no telegram.
  [[nodiscard]] std::int64_t broken() const {
    if constexpr (requires { dialogue_->broken(); })
      return static_cast<std::int64_t>(dialogue_->broken());
    return 0;
  }

  tims::os::File woken_;  // eventfd
  std::unique_ptr<Dialog> dialogue_;
  std::unique_ptr<Device> device_;
  tims::Time heard_{};
  bool has_told_end_ = false;  // of a recording
  bool has_taken_ = false;
  bool is_known_ = false;        // recognized, since it was opened
  std::string serial_number_;    // of the last one, since this program was started
  std::vector<std::byte> made_;  // while it is recorded or replayed
};

}  // namespace rack::device

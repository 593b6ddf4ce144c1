// A transport that plays a recording: received data arrive with the recorded timing, and data sent
// during the recording arrive as such (Arrival::is_sent). Output is discarded. Supports captures,
// candump logs, packet captures (payloads of UDP and TCP), raw bytes, and a folder of pictures
// (.jpg) as the frames of a camera.
#include <algorithm>
#include <cmath>
#include <utility>

#include <sys/timerfd.h>

#include "components/devices/io/transports.h"
#include "os/clock.h"
#include "os/file.h"
#include "rack/devices/recording.h"

namespace rack::device {
namespace {

using tims::Result;
using tims::os::File;
using tims::os::system_error;

class Playback final : public Transport {
 public:
  Playback(std::unique_ptr<Recording> recording, File timer, const DeviceAddress& address)
      : recording_(std::move(recording)),
        timer_(std::move(timer)),
        speed_(address.speed()),
        loops_(address.loops()),
        address_(address.to_string()) {}

  [[nodiscard]] int descriptor() const override { return timer_.get(); }
  [[nodiscard]] Time next_timeout() const override { return due_; }
  [[nodiscard]] std::string description() const override {
    return address_ + " (" + recording_->format() + ")";
  }
  [[nodiscard]] bool is_recording() const override { return true; }
  [[nodiscard]] bool is_over() const override { return is_over_; }
  std::optional<std::string> take_event() override { return std::exchange(event_, {}); }

  // Passes one record at a time, even if several are due: the caller must be able to take the
  // result of one record before the next one arrives.
  Result<void> receive(Time now, const Receive& receive) override {
    bool has_played = false;
    while (!is_over_ && due_ <= now && !has_played) {
      has_played = has_record_;
      const Time when = speed_ == 0 ? now : due_;
      const Duration took = speed_ == 0 ? Duration(0) : at_speed(record_.took);
      if (has_record_)
        receive({.bytes = record_.bytes,
                 .first = when - took,
                 .last = when,
                 .id = record_.id,
                 .is_sent = record_.direction == Direction::kSent});
      if (auto taken = take_next(now); !taken) return taken;
    }
    return {};
  }
  // Output is discarded.
  Result<bool> send(Time, std::span<const std::byte>, std::uint32_t) override { return true; }

 private:
  Result<void> take_next(Time now) {
    auto got = next_record();
    if (!got) return got.error();
    if (!*got && !std::exchange(has_ended_, true)) report_end();
    if (!*got && loops_) {
      recording_->rewind();
      began_.reset();
      got = next_record();
      if (!got) return got.error();
    }
    has_record_ = *got;
    is_over_ = !*got;
    if (is_over_) due_ = tims::kNever;
    if (is_over_ || speed_ == 0) return {};
    if (!began_) {
      began_ = record_.time;
      started_ = now;
    }
    due_ = started_ + at_speed(record_.time - *began_);
    return {};
  }
  void report_end() {
    std::string remarks = recording_->remarks();
    if (!has_record_)
      remarks = "there is nothing to play in it" + (remarks.empty() ? "" : "; " + remarks);
    if (!remarks.empty()) event_ = description() + ": " + remarks;
  }
  [[nodiscard]] Duration at_speed(Duration then) const {
    if (speed_ == 1) return std::max(Duration(0), then);
    const double now = static_cast<double>(then.count()) / speed_;
    return Duration(std::llround(std::clamp(now, 0.0, 1e18)));
  }

  Result<bool> next_record() {
    for (;;) {
      auto got = recording_->next(record_);
      const bool is_of_line =
          record_.direction == Direction::kReceived || record_.direction == Direction::kSent;
      if (!got || !*got || is_of_line) return got;
    }
  }

  std::unique_ptr<Recording> recording_;
  File timer_;  // never becomes readable: callers wait for next_timeout()
  double speed_;
  bool loops_;
  std::string address_;
  std::optional<std::string> event_;  // for take_event()
  bool has_ended_ = false;            // at least once
  CaptureRecord record_;
  bool has_record_ = false;
  bool is_over_ = false;
  std::optional<Duration> began_;  // time of the first record, which is played at once
  Time started_{};
  Time due_{};
};

}  // namespace

Result<std::unique_ptr<Transport>> open_playback(const DeviceAddress& address, std::uint32_t baud) {
  auto recording = open_recording(address, baud);
  if (!recording) return recording.error();
  File timer(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC));
  if (!timer) return system_error("timer");
  return std::unique_ptr<Transport>(
      std::make_unique<Playback>(std::move(*recording), std::move(timer), address));
}

}  // namespace rack::device

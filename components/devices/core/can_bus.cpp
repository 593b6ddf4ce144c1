#include "components/devices/core/can_bus.h"

#include <algorithm>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

// Classes of error frames, from linux/can/error.h.
constexpr std::uint32_t kTransmitTimeout = 0x001;
constexpr std::uint32_t kController = 0x004;
constexpr std::uint32_t kProtocol = 0x008;
constexpr std::uint32_t kTransceiver = 0x010;
constexpr std::uint32_t kNoAcknowledge = 0x020;
constexpr std::uint32_t kBusOff = 0x040;
constexpr std::uint32_t kBusError = 0x080;
constexpr std::uint32_t kRestarted = 0x100;

// Bits of the second data byte: the state of the controller.
constexpr unsigned kOverflow = 0x03;
constexpr unsigned kWarning = 0x0C;
constexpr unsigned kPassive = 0x30;

constexpr Duration kMinute = 60s;
constexpr Duration kFirstPause = 100ms;
constexpr Duration kLongestPause = 2s;
constexpr Duration kOffMax = 5s;
constexpr Duration kReportInterval = 1s;

}  // namespace

std::optional<std::string> CanBus::on_error_frame(std::uint32_t id,
                                                  std::span<const std::byte> bytes, Time now) {
  const unsigned controller =
      (id & kController) != 0 && bytes.size() > 1 ? std::to_integer<unsigned>(bytes[1]) : 0;
  if ((id & kRestarted) != 0) {
    ++counters_.restarts;
    off_since_ = next_restart_ = tims::kNever;
    return report(now, "is back on the bus");
  }
  if ((controller & kOverflow) != 0) ++counters_.lost;
  if ((controller & kWarning) != 0) ++counters_.warnings;
  if ((controller & kPassive) != 0) ++counters_.passive;
  if ((id & kNoAcknowledge) != 0) ++counters_.no_acknowledge;
  if ((id & (kProtocol | kBusError | kTransceiver | kTransmitTimeout)) != 0) ++counters_.errors;
  if ((id & kBusOff) != 0) {
    on_bus_off(now);
    // Bus-off is reported even if another message was reported less than a second ago, but repeated
    // bus-off only once a second.
    if (reported_off_ == Time{} || now - reported_off_ >= kReportInterval) reported_ = {};
    if (reported_ == Time{}) reported_off_ = now;
    return report(now,
                  "is bus-off; check the cable, the termination at both ends and the bit rate");
  }
  if ((id & kNoAcknowledge) != 0)
    return report(now, "receives no acknowledge; check that another node is on at this bit rate");
  if ((controller & kPassive) != 0) return report(now, "has many errors (error passive)");
  if ((controller & kOverflow) != 0) return report(now, "lost a frame: buffer overflow");
  return {};
}

std::optional<std::string> CanBus::report(Time now, std::string text) {
  if (reported_ != Time{} && now - reported_ < kReportInterval) return {};
  reported_ = now;
  return name_ + " " + std::move(text);
}

void CanBus::on_bus_off(Time now) {
  ++counters_.bus_off;
  if (off_since_ != tims::kNever) return;
  off_since_ = now;
  plan_restart(now);
}

void CanBus::plan_restart(Time now) {
  // After a minute without a restart, the pause starts at its minimum again.
  const Time last = restarted_ == 0 ? Time{} : restarts_[(restarted_ - 1) % kRestartsMax];
  const bool is_long_ago = last == Time{} || now - last > kMinute;
  pause_ = is_long_ago ? kFirstPause : std::min(2 * pause_, kLongestPause);
  const Time oldest = restarts_[restarted_ % kRestartsMax];
  is_given_up_ = oldest != Time{} && now - oldest < kMinute;
  next_restart_ = is_given_up_ ? oldest + kMinute : now + pause_;
}

void CanBus::on_open(Time now) {
  if (!is_off()) return;
  off_since_ = now;
  if (next_restart_ == tims::kNever) plan_restart(now);
}

void CanBus::on_restart(Time now) {
  restarts_[restarted_++ % kRestartsMax] = now;
  next_restart_ = tims::kNever;
  is_given_up_ = false;
}

std::optional<std::string> CanBus::failure(Time now) const {
  if (is_off() && is_given_up_)
    return name_ + " went bus-off more than " + std::to_string(kRestartsMax) + " times a minute";
  if (is_off() && now - off_since_ > kOffMax)
    return name_ + " is bus-off; to restart it automatically: ip link set " + name_ +
           " type can restart-ms 100";
  return {};
}

bool CanQueue::add(std::uint32_t id, std::span<const std::byte> bytes, Time deadline) {
  constexpr std::uint32_t kExtended = 0x80000000;
  constexpr std::uint32_t kIdOfExtended = 0x1FFFFFFF;
  constexpr std::uint32_t kIdOfStandard = 0x7FF;
  const auto rank = [](const Frame& frame) {
    return (frame.id & kExtended) != 0 ? std::uint64_t{frame.id & kIdOfExtended} << 3 | 7
                                       : std::uint64_t{frame.id & kIdOfStandard} << 21;
  };
  Frame frame{.id = id, .size = static_cast<std::uint8_t>(bytes.size()), .deadline = deadline};
  if (bytes.size() > frame.bytes.size() || frames_.size() == kMost) return false;
  std::ranges::copy(bytes, frame.bytes.begin());
  frames_.insert(std::ranges::upper_bound(frames_, rank(frame), {}, rank), frame);
  return true;
}

std::size_t CanQueue::drop_late(Time now) {
  return std::erase_if(frames_, [&](const Frame& frame) { return frame.deadline < now; });
}

std::string CanBus::summary() const {
  std::string text;
  const auto add = [&](std::uint64_t count, const char* what) {
    if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + what;
  };
  add(counters_.bus_off, "bus-off");
  add(counters_.restarts, "restarts");
  add(counters_.no_acknowledge, "without acknowledge");
  add(counters_.lost, "lost");
  add(counters_.warnings, "warnings");
  add(counters_.passive, "error passive");
  add(counters_.errors, "errors");
  add(counters_.late, "too late to be sent");
  return text;
}

}  // namespace rack::device

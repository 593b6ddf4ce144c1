#include "components/world/plugged_device.h"

#include <algorithm>

#include "components/devices/io/line.h"

namespace rack::device {
namespace {

constexpr Duration kRetry = std::chrono::seconds(1);

struct Nobody final : Output {
  void send(std::span<const std::byte>, std::uint32_t) override {}
};

}  // namespace

tims::Result<void> PluggedDevice::open() {
  auto line = open_line(address_, baud_);
  if (!line) return line.error();
  device_ = Device::with(std::move(*line), *emulator_);
  return {};
}

tims::Result<void> PluggedDevice::plug() {
  if (is_plugged_) return {};
  if (auto opened = open(); !opened) return opened;
  is_plugged_ = true;
  return {};
}

void PluggedDevice::pull() {
  is_plugged_ = false;
  retry_ = tims::kNever;
  device_.reset();
}

std::optional<std::string> PluggedDevice::serve(Time now) {
  if (retry_ <= now) retry_ = open() ? tims::kNever : now + kRetry;
  if (!device_) {
    Nobody nobody;
    if (emulator_->next_timeout() <= now) emulator_->on_timeout(now, nobody);
    return {};
  }
  const auto waited = device_->wait(now);
  if (waited) return {};
  device_.reset();
  retry_ = now + kRetry;
  return name_ + ": " + waited.error().detail();
}

Time PluggedDevice::next_timeout() const {
  const Time of_device = device_ ? device_->next_timeout() : emulator_->next_timeout();
  return std::min(of_device, retry_);
}

}  // namespace rack::device

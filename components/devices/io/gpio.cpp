// Transport of the computer's pins, by the kernel's GPIO character device (Linux 5.10 and later).
//
//   gpio:/dev/gpiochip0?in=17,27&out=22&bias=pull-up
//
// An arrival is the level of one line: the id is its offset, the byte is 0 or 1. All levels arrive
// once after opening, and those of inputs after each change, with the kernel's time stamp. Sending
// a byte with the id of an output sets that output. gpioinfo lists the lines.
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "base/text.h"
#include "components/devices/io/transports.h"
#include "os/file.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;
using tims::os::File;
using tims::os::system_error;

constexpr std::string_view kConsumer = "rack";

Result<std::vector<std::uint32_t>> lines_of(const DeviceAddress& address, std::string_view name) {
  std::vector<std::uint32_t> lines;
  const auto found = address.options.find(name);
  const std::string list = found == address.options.end() ? "" : found->second;
  for (std::size_t at = 0; at < list.size();) {
    const std::string one = list.substr(at, list.find(',', at) - at);
    const auto number = tims::base::parse_number<std::uint32_t>(one);
    if (!number)
      return Error(Errc::kInvalidArgument,
                   std::string(name) + " must be offsets of lines, for example 17,27, not " + list);
    lines.push_back(*number);
    at += one.size() + 1;
  }
  return lines;
}

Result<std::uint64_t> bias_of(const DeviceAddress& address) {
  const auto found = address.options.find("bias");
  if (found == address.options.end()) return std::uint64_t{0};
  if (found->second == "pull-up") return std::uint64_t{GPIO_V2_LINE_FLAG_BIAS_PULL_UP};
  if (found->second == "pull-down") return std::uint64_t{GPIO_V2_LINE_FLAG_BIAS_PULL_DOWN};
  if (found->second == "none") return std::uint64_t{GPIO_V2_LINE_FLAG_BIAS_DISABLED};
  return Error(Errc::kInvalidArgument, "bias must be pull-up, pull-down or none");
}

class GpioLines final : public Transport {
 public:
  GpioLines(File lines, std::vector<std::uint32_t> offsets, std::size_t inputs,
            std::string description)
      : file_(std::move(lines)),
        offsets_(std::move(offsets)),
        inputs_(inputs),
        description_(std::move(description)) {}

  [[nodiscard]] int descriptor() const override { return file_.get(); }
  [[nodiscard]] std::string description() const override { return description_; }

  Result<void> receive(Time now, const Receive& receive) override {
    if (!std::exchange(has_reported_, true)) {
      if (auto reported = report_all(now, receive); !reported) return reported;
    }
    std::array<gpio_v2_line_event, 16> events{};
    for (;;) {
      const ssize_t size = ::read(file_.get(), events.data(), sizeof events);
      if (size < 0 && errno == EINTR) continue;
      if (size < 0 && errno == EAGAIN) return {};
      if (size <= 0) return Error(Errc::kSystem, description_ + " is gone");
      const auto count = static_cast<std::size_t>(size) / sizeof events[0];
      for (const gpio_v2_line_event& event : std::span(events).first(count)) {
        const Time when =
            std::min(Time(Duration(static_cast<std::int64_t>(event.timestamp_ns))), now);
        report(event.offset, event.id == GPIO_V2_LINE_EVENT_RISING_EDGE, when, receive);
      }
    }
  }

  Result<bool> send(Time, std::span<const std::byte> bytes, std::uint32_t id) override {
    const auto line =
        std::find(offsets_.begin() + static_cast<std::ptrdiff_t>(inputs_), offsets_.end(), id);
    if (bytes.size() != 1 || line == offsets_.end()) return false;
    const std::uint64_t bit = std::uint64_t{1} << (line - offsets_.begin());
    gpio_v2_line_values values{};
    values.mask = bit;
    values.bits = bytes[0] != std::byte{0} ? bit : 0;
    if (::ioctl(file_.get(), GPIO_V2_LINE_SET_VALUES_IOCTL, &values) == 0) return true;
    if (errno == ENODEV) return Error(Errc::kSystem, description_ + " is gone");
    return false;
  }

 private:
  static void report(std::uint32_t offset, bool is_high, Time when, const Receive& receive) {
    const std::array level = {is_high ? std::byte{1} : std::byte{0}};
    receive({.bytes = level, .first = when, .last = when, .id = offset});
  }

  Result<void> report_all(Time now, const Receive& receive) {
    gpio_v2_line_values values{};
    values.mask =
        offsets_.size() == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << offsets_.size()) - 1;
    if (::ioctl(file_.get(), GPIO_V2_LINE_GET_VALUES_IOCTL, &values) != 0)
      return system_error(description_);
    for (std::size_t i = 0; i < offsets_.size(); ++i)
      report(offsets_[i], (values.bits >> i & 1) != 0, now, receive);
    return {};
  }

  File file_;
  std::vector<std::uint32_t> offsets_;  // inputs, then outputs
  std::size_t inputs_;
  std::string description_;
  bool has_reported_ = false;
};

}  // namespace

Result<std::unique_ptr<Transport>> open_gpio(const DeviceAddress& address) {
  auto offsets = lines_of(address, "in");
  if (!offsets) return offsets.error();
  const auto outputs = lines_of(address, "out");
  if (!outputs) return outputs.error();
  const auto bias = bias_of(address);
  if (!bias) return bias.error();
  const std::size_t inputs = offsets->size();
  offsets->insert(offsets->end(), outputs->begin(), outputs->end());
  if (offsets->empty() || offsets->size() > GPIO_V2_LINES_MAX)
    return Error(Errc::kInvalidArgument,
                 "1 to 64 lines are required; example: gpio:/dev/gpiochip0?in=17,27&out=22");

  const File chip(::open(address.place.c_str(), O_RDWR | O_CLOEXEC));
  if (!chip) return system_error(address.place);
  gpio_v2_line_request request{};
  std::ranges::copy(*offsets, request.offsets);
  std::ranges::copy(kConsumer, request.consumer);
  request.num_lines = static_cast<std::uint32_t>(offsets->size());
  request.config.flags = GPIO_V2_LINE_FLAG_INPUT | GPIO_V2_LINE_FLAG_EDGE_RISING |
                         GPIO_V2_LINE_FLAG_EDGE_FALLING | *bias;
  if (!outputs->empty()) {
    request.config.num_attrs = 1;
    request.config.attrs[0].attr.id = GPIO_V2_LINE_ATTR_ID_FLAGS;
    request.config.attrs[0].attr.flags = GPIO_V2_LINE_FLAG_OUTPUT;
    for (std::size_t i = inputs; i < offsets->size(); ++i)
      request.config.attrs[0].mask |= std::uint64_t{1} << i;
  }
  if (::ioctl(chip.get(), GPIO_V2_GET_LINE_IOCTL, &request) != 0)
    return Error(Errc::kSystem, system_error(address.place).detail() +
                                    "; gpioinfo lists the lines and their users");
  File lines(request.fd);
  ::fcntl(lines.get(), F_SETFL, O_NONBLOCK);
  return std::unique_ptr<Transport>(std::make_unique<GpioLines>(
      std::move(lines), std::move(*offsets), inputs, address.to_string()));
}

}  // namespace rack::device

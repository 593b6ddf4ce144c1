#include "components/devices/io/pulse.h"

#include <array>
#include <chrono>
#include <filesystem>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <linux/pps.h>
#include <sys/ioctl.h>

#include "components/devices/io/udev_library.h"

namespace rack::device {
namespace {

using tims::os::File;

// An attribute of a device; empty if it has none.
std::string attribute_of(udev_device* device, const char* name) {
  const char* const value = ::udev_device_get_sysattr_value(device, name);
  return value == nullptr ? std::string() : value;
}

}  // namespace

std::string Pulse::find(const std::string& serial_line) {
  constexpr std::array<const char*, 1> kSubsystems = {"pps"};
  std::error_code error;
  const auto wanted = std::filesystem::canonical(serial_line, error);
  std::vector<std::string> of_no_line;
  for (const auto& source : udev_devices(kSubsystems)) {
    const char* const device = ::udev_device_get_devnode(source.get());
    if (device == nullptr) continue;
    const std::string line = attribute_of(source.get(), "path");  // the terminal
    if (line.empty()) of_no_line.emplace_back(device);
    if (!line.empty() && !wanted.empty() && wanted == line) return device;
  }
  return of_no_line.size() == 1 ? of_no_line.front() : "";
}

tims::Result<Pulse> Pulse::open(const std::string& path) {
  File file(::open(path.c_str(), O_RDWR | O_CLOEXEC));
  if (!file) return tims::os::system_error(path);
  return Pulse(std::move(file));
}

std::optional<tims::Duration> Pulse::last() const {
  pps_fdata data{};  // timeout 0: does not block
  if (::ioctl(file_.get(), PPS_FETCH, &data) != 0 || data.info.assert_sequence == 0)
    return std::nullopt;
  return std::chrono::seconds(data.info.assert_tu.sec) +
         std::chrono::nanoseconds(data.info.assert_tu.nsec);
}

}  // namespace rack::device

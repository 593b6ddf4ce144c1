#include "components/devices/io/pulse.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <linux/pps.h>
#include <sys/ioctl.h>

namespace rack::device {
namespace {

using tims::os::File;

// The terminal of a PPS source according to the kernel, or an empty string.
std::string line_of(const std::filesystem::path& source) {
  std::ifstream file(source / "path");
  std::string path;
  std::getline(file, path);
  return path;
}

}  // namespace

std::string Pulse::find(const std::string& serial_line) {
  std::error_code error;
  const auto wanted = std::filesystem::canonical(serial_line, error);
  std::vector<std::string> of_no_line;
  for (const auto& source : std::filesystem::directory_iterator("/sys/class/pps", error)) {
    const std::string device = "/dev/" + source.path().filename().string();
    const std::string line = line_of(source.path());
    if (line.empty()) of_no_line.push_back(device);
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

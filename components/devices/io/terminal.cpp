#include "components/devices/io/terminal.h"

#include <array>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include <asm/termbits.h>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;
using tims::os::File;
using tims::os::system_error;

constexpr const char* kTerminals = "/dev/pts/";

// Turns echo off. Otherwise the terminal would return the bytes sent until a driver configures it.
void hand_nothing_back(int file) {
  termios2 settings{};
  if (::ioctl(file, TCGETS2, &settings) != 0) return;
  settings.c_iflag = settings.c_oflag = settings.c_lflag = 0;
  ::ioctl(file, TCSETS2, &settings);
}

// A lock of the whole file by this descriptor. Drivers use locks of flock(2), which are others.
struct flock whole_file() {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

// Of the terminal that the link leads to; empty if it leads nowhere.
Result<std::string> target_of(const std::string& link) {
  std::error_code failed;
  const auto kind = std::filesystem::symlink_status(link, failed).type();
  if (kind == std::filesystem::file_type::not_found) return std::string();
  std::string target = std::filesystem::read_symlink(link, failed).string();
  if (!target.starts_with(kTerminals))
    return Error(
        Errc::kInvalidArgument,
        link + " exists and is no link to a pseudo terminal: choose another path, or remove it");
  return target;
}

bool is_in_use(const std::string& terminal) {
  const File file(::open(terminal.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  struct flock lock = whole_file();
  return file && ::fcntl(file.get(), F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

Result<void> make_room_for_link(const std::string& path) {
  const auto target = target_of(path);
  if (!target) return target.error();
  if (target->empty()) return {};
  if (is_in_use(*target))
    return Error(Errc::kSystem, path +
                                    " is the line of an emulated device that is running; is a "
                                    "robot of this number up? See timsctl "
                                    "down, or choose another --system");
  ::unlink(path.c_str());
  return {};
}

}  // namespace

Result<void> make_raw(int file, std::uint32_t baud, const std::string& parity) {
  termios2 settings{};
  if (::ioctl(file, TCGETS2, &settings) != 0) return system_error("not a serial line");
  settings.c_iflag = 0;
  settings.c_oflag = 0;
  settings.c_lflag = 0;
  settings.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
  if (parity == "even" || parity == "odd") settings.c_cflag |= PARENB;
  if (parity == "odd") settings.c_cflag |= PARODD;
  settings.c_ispeed = settings.c_ospeed = baud;
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  if (::ioctl(file, TCSETSF2, &settings) != 0)
    return system_error("cannot set " + std::to_string(baud) + " baud");
  return {};
}

Result<Terminal> Terminal::make(const std::string& path, std::uint32_t baud) {
  if (auto room = make_room_for_link(path); !room) return room.error();
  File own(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  std::array<char, 64> name{};
  if (!own || ::grantpt(own.get()) != 0 || ::unlockpt(own.get()) != 0 ||
      ::ptsname_r(own.get(), name.data(), name.size()) != 0)
    return system_error("cannot create a pseudo terminal");
  File other(::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  struct flock lock = whole_file();
  if (!other || ::fcntl(other.get(), F_OFD_SETLK, &lock) != 0) return system_error(name.data());
  if (baud == 0)
    hand_nothing_back(other.get());
  else if (auto raw = make_raw(other.get(), baud, ""); !raw)
    return raw.error();
  if (::symlink(name.data(), path.c_str()) != 0) return system_error(path);
  return Terminal(std::move(own), std::move(other), path, name.data());
}

Terminal::~Terminal() {
  if (!other_) return;
  std::error_code failed;
  if (std::filesystem::read_symlink(link_, failed) == name_) ::unlink(link_.c_str());
}

}  // namespace rack::device

// Serial lines, and pseudo terminals used in place of them.
#include <array>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <string>

#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include "base/text.h"
#include "components/devices/io/stream.h"
#include "components/devices/io/terminal.h"
#include "components/devices/io/transports.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;
using tims::os::File;

std::string first_line_of(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

// The process that holds the lock of a file, for example "LadarSickLms200 (pid 4711)". The kernel's
// list of locks has lines such as "1: FLOCK  ADVISORY  WRITE 4711 00:06:88 0 EOF".
std::string holder_of(int file) {
  struct stat status {};
  if (::fstat(file, &status) != 0) return "another program";
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    const auto fields = tims::base::split_words(line);
    if (!fields || fields->size() < 6 || (*fields)[1] != "FLOCK") continue;
    const std::string& place = (*fields)[5];
    const std::size_t colon = place.rfind(':');
    if (place.substr(colon + 1) != std::to_string(status.st_ino)) continue;
    const std::string& pid = (*fields)[4];
    return first_line_of("/proc/" + pid + "/comm").append(" (pid ").append(pid).append(")");
  }
  return "another program";
}

// Shortens the latency timer of a USB converter: the default of 16 ms exceeds the period of scans
// at 75 Hz.
bool make_low_latency(int file) {
  serial_struct serial{};
  if (::ioctl(file, TIOCGSERIAL, &serial) != 0) return false;
  serial.flags |= ASYNC_LOW_LATENCY;
  return ::ioctl(file, TIOCSSERIAL, &serial) == 0;
}

class SerialLine : public StreamTransport {
 public:
  using StreamTransport::StreamTransport;

  void set_baud(std::uint32_t baud) override {
    termios2 settings{};
    if (::ioctl(file_.get(), TCGETS2, &settings) != 0) return;
    settings.c_cflag = (settings.c_cflag & ~static_cast<tcflag_t>(CBAUD)) | BOTHER;
    settings.c_ispeed = settings.c_ospeed = baud;
    // Discards bytes received at the previous rate.
    if (::ioctl(file_.get(), TCSETSF2, &settings) == 0) baud_ = baud;
  }

  void set_dtr(bool on) override {
    int line = TIOCM_DTR;
    ::ioctl(file_.get(), on ? TIOCMBIS : TIOCMBIC, &line);
  }

 private:
  // read() returns 0 on an idle line as well as on an unplugged one; an ioctl shows the difference.
  Result<void> on_end() override {
    int lines = 0;
    if (::ioctl(file_.get(), TIOCMGET, &lines) == 0 || errno == ENOTTY || errno == EINVAL)
      return {};
    return Error(Errc::kSystem, "the device is gone");
  }
};

class PseudoTerminal final : public SerialLine {
 public:
  PseudoTerminal(Terminal terminal, std::uint32_t baud, const std::string& link)
      : SerialLine(terminal.take_own(), link, baud), terminal_(std::move(terminal)) {}

 private:
  Terminal terminal_;
};

}  // namespace

Result<std::unique_ptr<Transport>> open_serial(const DeviceAddress& address, std::uint32_t baud) {
  File file(::open(address.place.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!file) return cannot_open_device(address.place, "dialout");
  if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0)
    return Error(Errc::kSystem, address.place + " is used by " + holder_of(file.get()));
  const auto parity = address.options.find("parity");
  const std::uint32_t rate = address.baud(baud);
  if (auto raw = make_raw(file.get(), rate, parity == address.options.end() ? "" : parity->second);
      !raw)
    return Error(Errc::kSystem, address.place + ": " + raw.error().detail());
  std::string description = address.place + " at " + std::to_string(rate) + " baud";
  if (make_low_latency(file.get())) description += ", low latency";
  return std::unique_ptr<Transport>(
      std::make_unique<SerialLine>(std::move(file), std::move(description), rate));
}

Result<std::unique_ptr<Transport>> open_pty(const DeviceAddress& address, std::uint32_t baud) {
  const std::uint32_t rate = address.baud(baud);
  auto made = Terminal::make(address.place, rate);
  if (!made) return made.error();
  return std::unique_ptr<Transport>(
      std::make_unique<PseudoTerminal>(std::move(*made), rate, address.place));
}

}  // namespace rack::device

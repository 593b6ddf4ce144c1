// A pseudo terminal in place of a serial line, and the link by which programs find it.
//
// The link belongs to the terminal as long as that is open. While it leads to a terminal in use, no
// other one takes it over; the link of a program that was killed is replaced. A file of another
// kind at that path is never touched.
#pragma once

#include <cstdint>
#include <string>

#include "os/file.h"

namespace rack::device {

class Terminal {
 public:
  // `path`: of the link. `baud`: initial rate; 0: only echo is turned off, the program that opens
  // the other end configures the rest. Errors: the path is in use, or is no link to a terminal.
  static tims::Result<Terminal> make(const std::string& path, std::uint32_t baud);
  Terminal(Terminal&&) noexcept = default;
  Terminal& operator=(Terminal&&) noexcept = delete;
  // Removes the link unless it leads elsewhere by now.
  ~Terminal();

  // This end, to be owned by the caller.
  [[nodiscard]] tims::os::File take_own() { return std::move(own_); }
  // The other end. It stays open, so that a program that opens and closes it does not cause a
  // hangup.
  [[nodiscard]] int other() const { return other_.get(); }

 private:
  Terminal(tims::os::File own, tims::os::File other, std::string link, std::string name)
      : own_(std::move(own)),
        other_(std::move(other)),
        link_(std::move(link)),
        name_(std::move(name)) {}

  tims::os::File own_;
  tims::os::File other_;
  std::string link_;
  std::string name_;  // of the other end: "/dev/pts/7"
};

// Sets 8 data bits, no translation of characters, and ignores modem control lines. `parity`:
// "even", "odd", or anything else for none.
tims::Result<void> make_raw(int file, std::uint32_t baud, const std::string& parity);

}  // namespace rack::device

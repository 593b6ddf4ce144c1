// A file to which whole lines are appended: the one rule for all files that grow, so that neither a
// full disk nor a crash leaves a part of a line. When the disk is full, operations fail with
// kDiskFull. It may also be a pipe or a device such as /dev/null.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "os/file.h"

namespace rack {

class LogFile {
 public:
  LogFile() = default;

  // Begins an empty file that the caller has created for appending.
  void begin(tims::os::File file, std::string path);
  // Opens a file to append to it. Returns the number of bytes removed from an incomplete last line,
  // which a loss of power may leave.
  tims::Result<std::uint64_t> open(const std::string& path);
  // Appends all of the text or nothing.
  tims::Result<void> append(std::string_view text);
  // Flushes the file to the disk, so that it survives a loss of power.
  tims::Result<void> sync();
  void close() { file_.reset(); }

  [[nodiscard]] bool is_open() const { return static_cast<bool>(file_); }
  [[nodiscard]] std::uint64_t size() const { return static_cast<std::uint64_t>(size_); }

 private:
  [[nodiscard]] tims::Error error() const;
  [[nodiscard]] tims::Result<off_t> end_of_lines(off_t size) const;

  std::string path_;
  tims::os::File file_;
  off_t size_ = 0;
};

// Flushes a folder to the disk, after files in it were created or renamed.
tims::Result<void> sync_folder(const std::string& path);

}  // namespace rack

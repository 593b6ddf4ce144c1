// A file that grows by whole lines, also on a disk that is full at times: kDiskFull then.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "os/file.h"

namespace rack {

class LogFile {
 public:
  LogFile() = default;

  // Begins anew.
  tims::Result<void> create(const std::string& path);
  // Goes on behind what is there. Returns how many bytes of a line without end had to go: the power
  // went while it was written.
  tims::Result<std::uint64_t> open(const std::string& path);
  // All of it, or nothing.
  tims::Result<void> append(std::string_view text);
  // To the disk itself, where it outlives a loss of power.
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

// Names in a folder, of files that were made or renamed, to the disk itself.
tims::Result<void> sync_folder(const std::string& path);

}  // namespace rack

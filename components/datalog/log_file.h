// A file that grows by whole lines, also on a disk that is full at times.
#pragma once

#include <string>

#include "os/file.h"

namespace rack::datalog {

class LogFile {
 public:
  LogFile() = default;

  // Begins anew.
  tims::Result<void> create(const std::string& path);
  // All of it, or nothing.
  tims::Result<void> append(std::string_view text);

 private:
  std::string path_;
  tims::os::File file_;
  off_t size_ = 0;
};

}  // namespace rack::datalog

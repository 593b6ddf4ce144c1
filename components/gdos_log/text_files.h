// The texts on disk: a file that grows, and what it held before. Nothing that was synchronised is
// lost with the power; half a line at the end is cut off when it is opened again.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "components/files/log_file.h"
#include "os/file.h"

namespace rack::gdos_log {

struct TextFileLimits {
  std::uint64_t bytes = 10 << 20;  // of one file
  std::uint32_t files = 10;        // with the one that grows
  std::chrono::days age{0};        // of a file that grows no more; 0: any
};

class TextFiles {
 public:
  // Makes the folder. Returns how many bytes of half a line were cut off. kAddressInUse: another
  // program writes there.
  tims::Result<std::uint64_t> open(const std::filesystem::path& folder,
                                   const TextFileLimits& limits);
  void close();
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

  // All of it, or nothing. kDiskFull: later there may be room.
  tims::Result<void> append(std::string_view line);
  // What was appended is on the disk then. Begins a new file when somebody took this one away.
  tims::Result<void> sync();

 private:
  [[nodiscard]] std::filesystem::path current() const;
  tims::Result<void> lock();
  tims::Result<std::uint64_t> open_current();
  tims::Result<void> begin_another();
  void remove_old() const;
  [[nodiscard]] bool was_taken_away() const;

  std::filesystem::path folder_;
  TextFileLimits limits_;
  tims::os::File lock_;
  LogFile file_;
  bool unsynced_ = false;
};

}  // namespace rack::gdos_log

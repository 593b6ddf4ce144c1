// Where texts go: to files that grow and are replaced, and to the journal of the host.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "components/files/log_file.h"
#include "os/file.h"
#include "proxies/gdos_texts.h"
#include "rack/text_log.h"
#include "tims/result.h"

namespace rack::gdos_log {

// --- The texts on disk: a file that grows, and what it held before. Nothing that was synchronised
// is lost with the power; half a line at the end is cut off when it is opened again.

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
  tims::Result<void> rotate();
  void remove_old() const;
  [[nodiscard]] bool was_removed() const;

  std::filesystem::path folder_;
  TextFileLimits limits_;
  tims::os::File lock_;
  LogFile file_;
  bool unsynced_ = false;
};

// --- Texts in the journal of the host, with fields to look for:
//   journalctl TIMS_COMPONENT='Chassis(0/0)' -p warning

// The priority of syslog: what `journalctl -p` counts.
int journal_priority(gdos::Level level);

// A host without a journal takes no notice. Pieces: MESSAGE, PRIORITY, SYSLOG_IDENTIFIER (the
// component), TIMS_ADDRESS, TIMS_COMPONENT, TIMS_LEVEL.
tims::Result<void> to_journal(const gdos::Record& record);

// Whether standard error goes there: a service of systemd.
bool runs_under_journal();

// --- Where texts go: to files, and to the journal when asked. What cannot be written stops nobody:
// it is said once and counted, and tried again with the next text.

class TextKeeper {
 public:
  TextKeeper(TextLog& log, tims::Duration sync_each, bool journal)
      : log_(log), sync_each_(sync_each), journal_(journal) {}

  tims::Result<void> open(const std::filesystem::path& folder, const TextFileLimits& limits);
  void keep(const gdos::Record& record);
  // Often: what is older than `sync_each` goes to the disk.
  void on_time(tims::Time now);

 private:
  void report(const tims::Result<void>& written);

  TextLog& log_;
  tims::Duration sync_each_;
  bool journal_;
  TextFiles files_;
  tims::Time next_sync_{};
  std::uint32_t not_kept_ = 0;  // since it last went well
  bool journal_failed_ = false;
};

}  // namespace rack::gdos_log

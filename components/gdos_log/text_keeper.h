// Where texts go: to files, and to the journal when asked. What cannot be written stops nobody: it
// is said once and counted, and tried again with the next text.
#pragma once

#include "components/gdos_log/text_files.h"
#include "proxies/gdos_texts.h"
#include "rack/text_log.h"

namespace rack::gdos_log {

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

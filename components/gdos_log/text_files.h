// Storage of log texts: limits per sender, the log files with rotation, and the journal of the
// host.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/rate_limiter.h"
#include "components/files/log_file.h"
#include "os/file.h"
#include "proxies/gdos_texts.h"
#include "rack/proxies/gdos.h"
#include "rack/text_log.h"
#include "tims/result.h"

namespace rack::gdos_log {

// --- Rate limits. Each component has its own limit, so that a single one cannot fill the disk, and
// details cannot displace errors.
//
// A sender has two token buckets, one for prints, errors and warnings and one for the rest: a
// burst, then a steady rate. Suppressed texts are counted and reported from time to time. The
// number of senders is limited; when it is reached, senders with full buckets are removed, as they
// are equivalent to new ones, and further senders share one pair of buckets. Time is an argument.
class SenderLimits {
 public:
  // Number of senders with their own limit; all others share one.
  static constexpr std::size_t kSendersMax = 1024;
  // Above the limit that a component applies itself.
  static constexpr std::uint32_t kUrgentBurst = 400;
  static constexpr std::uint32_t kUrgentPerSecond = 50;
  static constexpr std::uint32_t kOtherBurst = 100;
  static constexpr std::uint32_t kOtherPerSecond = 20;
  // Minimum time between two reports about the same sender.
  static constexpr tims::Duration kReportEach = std::chrono::seconds(1);

  // Whether a text may be stored.
  bool take(tims::Time now, tims::Address sender, gdos::Level level);

  struct Suppressed {
    tims::Address sender;
    std::uint32_t count;
  };
  // The reports on suppressed texts that are due. Cheap when there are none.
  std::vector<Suppressed> take_suppressed(tims::Time now);

 private:
  struct Sender {
    tims::base::LineLimiter urgent{kUrgentPerSecond, kUrgentBurst};  // print, error, warning
    tims::base::LineLimiter other{kOtherPerSecond, kOtherBurst};     // info, detail
  };
  Sender& find(tims::Time now, tims::Address sender);

  std::map<tims::Address, Sender> senders_;
  bool any_suppressed_ = false;
  tims::Time next_report_{};
};

// --- The texts on disk: a current file and older ones. Synchronised texts survive a loss of power;
// an incomplete line at the end is removed at the next start.

struct TextFileLimits {
  std::uint64_t bytes = 10 << 20;  // per file
  std::uint32_t files = 10;        // including the current one
  std::chrono::days age{0};        // maximum age of older files; 0: no limit
};

class TextFiles {
 public:
  // Creates the folder. Returns the number of bytes of an incomplete line that were removed.
  // kAddressInUse: another program writes there.
  tims::Result<std::uint64_t> open(const std::filesystem::path& folder,
                                   const TextFileLimits& limits);
  void close();
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_; }

  // Appends the whole line or nothing. kDiskFull: there may be room later.
  tims::Result<void> append(std::string_view line);
  // Forces appended lines to the disk. Starts a new file when the current one was removed.
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

// The newest lines of the files in a folder, oldest first, together at most `bytes`.
std::string newest_lines(const std::filesystem::path& folder, std::size_t bytes);

// --- Texts in the journal of the host, with fields for queries:
//   journalctl TIMS_COMPONENT='Chassis(0/0)' -p warning

// The syslog priority, as used by `journalctl -p`.
int journal_priority(gdos::Level level);

// Does nothing on a host without a journal. Fields: MESSAGE, PRIORITY, SYSLOG_IDENTIFIER (the
// component), TIMS_ADDRESS, TIMS_COMPONENT, TIMS_LEVEL.
tims::Result<void> to_journal(const gdos::Record& record);

// Whether standard error is connected to the journal, as in a service of systemd.
bool runs_under_journal();

// --- Writes texts to files, and to the journal if configured. A failure does not stop the
// component: it is logged once, failures are counted, and the next text is tried again.

class TextWriter {
 public:
  TextWriter(TextLog& log, tims::Duration sync_each, bool journal)
      : log_(log), sync_each_(sync_each), journal_(journal) {}

  tims::Result<void> open(const std::filesystem::path& folder, const TextFileLimits& limits);
  void write(const gdos::Record& record);
  // Call it often: syncs texts that are older than `sync_each`.
  void on_time(tims::Time now);

 private:
  void report(const tims::Result<void>& written);

  TextLog& log_;
  tims::Duration sync_each_;
  bool journal_;
  TextFiles files_;
  tims::Time next_sync_{};
  std::uint32_t not_kept_ = 0;  // number of failures since the last success
  bool journal_failed_ = false;
};

}  // namespace rack::gdos_log

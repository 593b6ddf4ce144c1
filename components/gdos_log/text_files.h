// What becomes of the texts that components say: how many of each are kept, the files that they go
// to, which grow and are replaced, and the journal of the host.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
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

// --- How many texts of one component are kept. Each has its own limit, so that one that has much
// to say does not fill the disk, and details do not use up the room of errors.
//
// A sender has two token buckets, one for prints, errors and warnings and one for the rest: a
// burst, then a steady rate. What does not fit is counted, and told from time to time. There is
// room for so many senders; when it is used up, those whose buckets are full are forgotten, as they
// are like new ones, and who finds no room shares one pair of buckets. Time is an argument.
class SenderLimits {
 public:
  // Components that are told apart; what more of them say shares one limit.
  static constexpr std::size_t kSendersMax = 1024;
  // Above what a component of ours lets out by itself.
  static constexpr std::uint32_t kUrgentBurst = 400;
  static constexpr std::uint32_t kUrgentPerSecond = 50;
  static constexpr std::uint32_t kOtherBurst = 100;
  static constexpr std::uint32_t kOtherPerSecond = 20;
  // Between two words about the same flood.
  static constexpr tims::Duration kTellEach = std::chrono::seconds(1);

  // Whether a text may be kept.
  bool take(tims::Time now, tims::Address sender, gdos::Level level);

  struct Suppressed {
    tims::Address sender;
    std::uint32_t count;
  };
  // What has to be said by now of texts that were not kept. Cheap when there is nothing.
  std::vector<Suppressed> take_suppressed(tims::Time now);

 private:
  struct Sender {
    tims::base::LineLimiter urgent{kUrgentPerSecond, kUrgentBurst};  // print, error, warning
    tims::base::LineLimiter other{kOtherPerSecond, kOtherBurst};     // info, detail
  };
  Sender& find(tims::Time now, tims::Address sender);

  std::map<tims::Address, Sender> senders_;
  bool any_suppressed_ = false;
  tims::Time next_word_{};
};

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

class TextWriter {
 public:
  TextWriter(TextLog& log, tims::Duration sync_each, bool journal)
      : log_(log), sync_each_(sync_each), journal_(journal) {}

  tims::Result<void> open(const std::filesystem::path& folder, const TextFileLimits& limits);
  void write(const gdos::Record& record);
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

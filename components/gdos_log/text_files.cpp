#include "components/gdos_log/text_files.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/uio.h>
#include <systemd/sd-journal.h>

#include "proxies/gdos_texts.h"

// Prevents the library from adding this source file and line to each text.
#define SD_JOURNAL_SUPPRESS_LOCATION

namespace rack::gdos_log {

namespace {

namespace fs = std::filesystem;

constexpr tims::Address kEverybodyElse{0};

tims::Error failed(const fs::path& path, const std::error_code& error) {
  return {tims::Errc::kSystem, path.string() + ": " + error.message()};
}

}  // namespace

bool SenderLimits::take(tims::Time now, tims::Address sender, gdos::Level level) {
  Sender& from = find(now, sender);
  tims::base::LineLimiter& limiter = level >= gdos::Level::kWarning ? from.urgent : from.other;
  if (limiter.take(now)) return true;
  if (!any_suppressed_) next_report_ = now + kReportEach;
  any_suppressed_ = true;
  return false;
}

SenderLimits::Sender& SenderLimits::find(tims::Time now, tims::Address sender) {
  const auto known = senders_.find(sender);
  if (known != senders_.end()) return known->second;
  if (senders_.size() >= kSendersMax) {
    std::erase_if(senders_, [now](const auto& entry) {
      return entry.second.urgent.is_idle(now) && entry.second.other.is_idle(now);
    });
  }
  return senders_[senders_.size() < kSendersMax ? sender : kEverybodyElse];
}

std::vector<SenderLimits::Suppressed> SenderLimits::take_suppressed(tims::Time now) {
  std::vector<Suppressed> all;
  if (!any_suppressed_ || now < next_report_) return all;
  any_suppressed_ = false;
  for (auto& [address, sender] : senders_) {
    const std::uint32_t count = sender.urgent.take_held_back() + sender.other.take_held_back();
    if (count > 0) all.push_back({address, count});
  }
  return all;
}

// --- files

fs::path TextFiles::current() const { return folder_ / gdos::kCurrentFile; }

tims::Result<std::uint64_t> TextFiles::open(const fs::path& folder, const TextFileLimits& limits) {
  close();
  folder_ = folder;
  limits_ = limits;
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) return failed(folder_, error);
  if (auto locked = lock(); !locked) return locked.error();
  remove_old();
  return open_current();
}

void TextFiles::close() {
  if (file_.is_open()) (void)sync();
  file_.close();
  lock_.reset();
}

// Two programs that rename the same files would lose texts.
tims::Result<void> TextFiles::lock() {
  const fs::path path = folder_ / "lock";
  lock_ = tims::os::File(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!lock_) return tims::os::system_error(path.string());
  if (::flock(lock_.get(), LOCK_EX | LOCK_NB) == 0) return {};
  return tims::Error(tims::Errc::kAddressInUse,
                     folder_.string() + ": another program keeps its texts there");
}

tims::Result<std::uint64_t> TextFiles::open_current() {
  const auto cut = file_.open(current().string());
  if (!cut) return cut.error();
  unsynced_ = *cut > 0;
  if (auto good = sync_folder(folder_.string()); !good) return good.error();
  return *cut;
}

tims::Result<void> TextFiles::append(std::string_view line) {
  // Retries a file that could not be created on a full disk.
  if (!file_.is_open()) {
    if (auto opened = open_current(); !opened) return opened.error();
  }
  if (file_.size() > 0 && file_.size() + line.size() > limits_.bytes) {
    if (auto good = rotate(); !good) return good;
  }
  auto good = file_.append(line);
  unsynced_ = unsynced_ || good;
  return good;
}

tims::Result<void> TextFiles::sync() {
  if (file_.is_open() && was_removed()) file_.close();
  if (!file_.is_open() || !unsynced_) return {};
  unsynced_ = false;
  return file_.sync();
}

// Syncs the file before renaming it, so that each text exists exactly once after a crash at any
// point.
tims::Result<void> TextFiles::rotate() {
  if (auto good = sync(); !good) return good;
  const fs::path old = folder_ / gdos::numbered_file(gdos::log_files(folder_).next_number());
  file_.close();
  if (std::rename(current().c_str(), old.c_str()) != 0 && errno != ENOENT)
    return tims::os::system_error(current().string());
  remove_old();
  auto opened = open_current();
  return opened ? tims::Result<void>() : opened.error();
}

// Removes old files that are too many or too old.
void TextFiles::remove_old() const {
  const gdos::LogFiles files = gdos::log_files(folder_);
  const std::size_t kept = limits_.files > 0 ? limits_.files - 1 : 0;
  const auto oldest = fs::file_time_type::clock::now() - limits_.age;
  for (std::size_t i = 0; i < files.numbers.size(); ++i) {
    const fs::path path = folder_ / gdos::numbered_file(files.numbers[i]);
    std::error_code ignored;
    const bool too_many = files.numbers.size() - i > kept;
    const bool too_old = limits_.age.count() > 0 && fs::last_write_time(path, ignored) < oldest;
    if (too_many || too_old) fs::remove(path, ignored);
  }
}

bool TextFiles::was_removed() const {
  std::error_code ignored;
  return !fs::exists(current(), ignored);
}

namespace {

// At most the last `bytes` of a file. `whole`: there is nothing before them.
std::string end_of(const fs::path& path, std::size_t bytes, bool& whole) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file.tellg();
  if (!file || size <= 0) return {};
  const std::streamoff taken = std::min(size, static_cast<std::streamoff>(bytes));
  whole = taken == size;
  std::string end(static_cast<std::size_t>(taken), '\0');
  file.seekg(size - taken);
  file.read(end.data(), taken);
  end.resize(static_cast<std::size_t>(file.gcount()));
  return end;
}

}  // namespace

std::string newest_lines(const fs::path& folder, std::size_t bytes) {
  const std::vector<fs::path> paths = gdos::log_paths(folder);
  std::string lines;
  bool whole = true;
  for (auto path = paths.rbegin(); path != paths.rend() && whole && lines.size() < bytes; ++path)
    lines.insert(0, end_of(*path, bytes - lines.size(), whole));
  // A line may be incomplete: the first is cut, the last is being written.
  lines.resize(lines.rfind('\n') + 1);
  if (!whole) lines.erase(0, lines.find('\n') + 1);
  return lines;
}

// --- the journal

int journal_priority(gdos::Level level) {
  switch (level) {
    case gdos::Level::kError:
      return 3;
    case gdos::Level::kWarning:
      return 4;
    case gdos::Level::kPrint:
      return 5;
    case gdos::Level::kInfo:
      return 6;
    case gdos::Level::kDetail:
      return 7;
  }
  return 5;
}

tims::Result<void> to_journal(const gdos::Record& record) {
  std::array<std::string, 6> fields{
      "MESSAGE=" + record.text,
      "PRIORITY=" + std::to_string(journal_priority(record.level)),
      "SYSLOG_IDENTIFIER=" + record.component,
      "TIMS_ADDRESS=" + record.address.to_hex(),
      "TIMS_COMPONENT=" + record.component,
      "TIMS_LEVEL=" + std::string(gdos::name(record.level)),
  };
  std::array<iovec, 6> pieces{};
  for (std::size_t i = 0; i < fields.size(); ++i) pieces[i] = {fields[i].data(), fields[i].size()};
  const int sent = ::sd_journal_sendv(pieces.data(), static_cast<int>(pieces.size()));
  if (sent < 0)
    return tims::Error(tims::Errc::kSystem, "journal: " + std::generic_category().message(-sent));
  return {};
}

bool runs_under_journal() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): the environment is never changed
  return std::getenv("JOURNAL_STREAM") != nullptr;
}

// --- both

tims::Result<void> TextWriter::open(const std::filesystem::path& folder,
                                    const TextFileLimits& limits) {
  const auto opened = files_.open(folder, limits);
  // A full disk may have room later; a missing folder is a permanent error.
  if (!opened && opened.error().code() != tims::Errc::kDiskFull) return opened.error();
  if (opened && *opened > 0)
    log_.warning("removed {} bytes of an incomplete text at the end of the file", *opened);
  return {};
}

void TextWriter::write(const gdos::Record& record) {
  report(files_.append(gdos::to_line(record)));
  if (!journal_) return;
  const auto sent = to_journal(record);
  if (!sent && !journal_failed_) log_.warning("{}", sent.error().detail());
  journal_failed_ = !sent;
}

// Its own log texts come back to it as texts to store, so failures are logged only once.
void TextWriter::report(const tims::Result<void>& written) {
  if (!written) {
    if (not_kept_++ == 0) log_.error("Texts are not kept: {}", written.error().message());
    return;
  }
  if (const std::uint32_t lost = std::exchange(not_kept_, 0))
    log_.warning("Texts are kept again; {} were not", lost);
}

void TextWriter::on_time(tims::Time now) {
  if (now < next_sync_) return;
  next_sync_ = now + sync_each_;
  if (auto good = files_.sync(); !good) report(good);
}

}  // namespace rack::gdos_log

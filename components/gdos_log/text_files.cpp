#include "components/gdos_log/text_files.h"

#include <cstdio>

#include <fcntl.h>
#include <sys/file.h>

#include "proxies/gdos_texts.h"

namespace rack::gdos_log {
namespace {

namespace fs = std::filesystem;

tims::Error failed(const fs::path& path, const std::error_code& error) {
  return {tims::Errc::kSystem, path.string() + ": " + error.message()};
}

}  // namespace

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
  // A file that could not be begun, for a full disk.
  if (!file_.is_open()) {
    if (auto opened = open_current(); !opened) return opened.error();
  }
  if (file_.size() > 0 && file_.size() + line.size() > limits_.bytes) {
    if (auto good = begin_another(); !good) return good;
  }
  auto good = file_.append(line);
  unsynced_ = unsynced_ || good;
  return good;
}

tims::Result<void> TextFiles::sync() {
  if (file_.is_open() && was_taken_away()) file_.close();
  if (!file_.is_open() || !unsynced_) return {};
  unsynced_ = false;
  return file_.sync();
}

// What is in the file is on the disk before the file has another name: whatever happens meanwhile,
// each text is found once.
tims::Result<void> TextFiles::begin_another() {
  if (auto good = sync(); !good) return good;
  const fs::path old = folder_ / gdos::numbered_file(gdos::log_files(folder_).next_number());
  file_.close();
  if (std::rename(current().c_str(), old.c_str()) != 0 && errno != ENOENT)
    return tims::os::system_error(current().string());
  remove_old();
  auto opened = open_current();
  return opened ? tims::Result<void>() : opened.error();
}

// Files that grow no more: too many, or too old.
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

bool TextFiles::was_taken_away() const {
  std::error_code ignored;
  return !fs::exists(current(), ignored);
}

}  // namespace rack::gdos_log

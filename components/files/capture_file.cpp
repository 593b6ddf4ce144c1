#include "components/files/capture_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/measure.h"
#include "os/clock.h"

namespace rack::device {
namespace {

using tims::Result;
using tims::os::File;

constexpr std::size_t kWaitingMax = 8 << 20;
constexpr auto kWriteEvery = std::chrono::seconds(1);  // limits what a loss of power can destroy
constexpr std::size_t kRecordOverhead = 80;

// Finds the time of the last record. `written`: modification time of the file.
tims::Duration end_of(int file, off_t size, const timespec& written) {
  constexpr off_t kTail = 256 << 10;
  std::string tail(static_cast<std::size_t>(std::min(size, kTail)), '\0');
  const ssize_t got = ::pread(file, tail.data(), tail.size(), std::max<off_t>(0, size - kTail));
  tail.resize(static_cast<std::size_t>(std::max<ssize_t>(0, got)));
  tims::Duration end = std::max(tims::Duration(0), tims::os::wall_now().time_since_epoch() -
                                                       (std::chrono::seconds(written.tv_sec) +
                                                        tims::Duration(written.tv_nsec)));
  CaptureRecord record;
  tail.resize(tail.rfind('\n') + 1);  // npos + 1 is 0: no whole line
  for (std::string_view rest = tail; !rest.empty();) {
    rest.remove_suffix(1);
    const std::size_t begin = rest.rfind('\n') + 1;
    if (const auto parsed = parse_record(rest.substr(begin), record);
        parsed && *parsed && record.direction != Direction::kMade)
      return end + record.time;
    rest = rest.substr(0, begin);
  }
  return end;
}

// The time at which an existing recording is continued; 0 for a new file and for other kinds of
// files (a pipe, /dev/null).
Result<tims::Duration> continued_at(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_size == 0)
    return tims::Duration(0);
  const File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) return tims::os::system_error(path);
  std::array<std::byte, 512> beginning{};
  const ssize_t got = ::pread(file.get(), beginning.data(), beginning.size(), 0);
  const auto size = static_cast<std::size_t>(std::max<ssize_t>(0, got));
  if (format_of(std::span(beginning).first(size)) != RecordingFormat::kCapture)
    return tims::Error(tims::Errc::kInvalidArgument,
                       path + " exists and is not a recording: not overwritten");
  return end_of(file.get(), status.st_size, status.st_mtim);
}

}  // namespace

Result<std::unique_ptr<CaptureFile>> CaptureFile::create(const std::string& path,
                                                         std::string_view device,
                                                         tims::Time begin) {
  const auto before = continued_at(path);
  if (!before) return before.error();
  LogFile file;
  if (const auto opened = file.open(path); !opened) return opened.error();
  auto capture =
      std::unique_ptr<CaptureFile>(new CaptureFile(std::move(file), path, begin - *before));
  const std::string header = capture_header(device, tims::base::rfc3339(tims::os::wall_now()));
  capture->append(header.size(), [&](std::string& text) { text += header; });
  return capture;
}

CaptureFile::CaptureFile(LogFile file, std::string path, tims::Time begin)
    : file_(std::move(file)), path_(std::move(path)), begin_(begin) {
  waiting_.reserve(kWaitingMax);
  writer_ = std::thread([this] { write_until_ended(); });
}

CaptureFile::~CaptureFile() { finish(); }

void CaptureFile::finish() {
  if (!writer_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_one();
  writer_.join();
}

template <typename Append>
void CaptureFile::append(std::size_t room, Append append) {
  const std::lock_guard lock(mutex_);
  if (waiting_.size() + room > kWaitingMax)
    ++lost_;
  else
    append(waiting_);
  // Frames of a camera may fill the buffer before the next periodic write.
  if (waiting_.size() > kWaitingMax / 2) changed_.notify_one();
}

void CaptureFile::add(tims::Time when, Direction direction, std::uint32_t id,
                      std::span<const std::byte> bytes, tims::Duration took) {
  append(2 * bytes.size() + kRecordOverhead, [&](std::string& text) {
    append_record(text, when - begin_, direction, id, bytes, took);
  });
}

void CaptureFile::add_event(tims::Time when, std::string_view event) {
  append(4 * event.size() + kRecordOverhead,
         [&](std::string& text) { append_event(text, when - begin_, event); });
}

std::uint64_t CaptureFile::lost() const {
  const std::lock_guard lock(mutex_);
  return lost_;
}

std::optional<std::string> CaptureFile::take_event() {
  const std::lock_guard lock(mutex_);
  return std::exchange(event_, {});
}

void CaptureFile::write_until_ended() {
  std::string text;
  text.reserve(kWaitingMax);
  for (bool ended = false; !ended;) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, kWriteEvery, [this] { return ended_; });
      ended = ended_;
      text.clear();
      std::swap(text, waiting_);
    }
    auto written = file_.append(text);
    if (written) written = file_.sync();
    on_written(text, written);
  }
}

void CaptureFile::on_written(std::string_view text, const Result<void>& written) {
  const std::lock_guard lock(mutex_);
  if (!written) {
    lost_ += static_cast<std::uint64_t>(std::ranges::count(text, '\n'));
    if (!std::exchange(failed_, true))
      event_ = written.error().detail() + "; records are lost until the file can be written";
  }
  // Reports lost records after the next successful write, or at the end.
  if (lost_ == reported_ || (!ended_ && (!written || text.empty()))) return;
  event_ = path_ + (written ? " is written again; " : " could not be written; ") +
           std::to_string(lost_ - reported_) + " records are missing in it";
  reported_ = lost_;
  failed_ = !written;
}

}  // namespace rack::device

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

// The state of an existing recording.
struct Continued {
  tims::Duration time{};
  bool is_cut = false;  // the last line is incomplete after a crash
};

// Finds the time of the last record. `written`: modification time of the file.
Continued end_of(int file, off_t size, const timespec& written) {
  constexpr off_t kTail = 256 << 10;
  std::string tail(static_cast<std::size_t>(std::min(size, kTail)), '\0');
  const ssize_t got = ::pread(file, tail.data(), tail.size(), std::max<off_t>(0, size - kTail));
  tail.resize(static_cast<std::size_t>(std::max<ssize_t>(0, got)));
  const tims::Duration ago =
      tims::os::wall_now().time_since_epoch() -
      (std::chrono::seconds(written.tv_sec) + tims::Duration(written.tv_nsec));
  Continued end{.time = std::max(tims::Duration(0), ago), .is_cut = !tail.ends_with('\n')};
  CaptureRecord record;
  for (std::string_view rest = tail; !rest.empty();) {
    const std::size_t length = rest.size() - (rest.ends_with('\n') ? 1 : 0);
    const std::size_t before = rest.substr(0, length).rfind('\n');  // or npos, which + 1 is 0
    if (const auto parsed = parse_record(rest.substr(before + 1, length - before - 1), record);
        parsed && *parsed && record.direction != Direction::kMade) {
      end.time += record.time;
      break;
    }
    rest = rest.substr(0, before + 1);
  }
  return end;
}

// Empty for a new file and for other kinds of files (a pipe, /dev/null).
Result<std::optional<Continued>> continued(int file, const std::string& path) {
  struct stat status {};
  if (::fstat(file, &status) != 0) return tims::os::system_error(path);
  if (!S_ISREG(status.st_mode) || status.st_size == 0) return std::optional<Continued>();
  std::array<std::byte, 512> beginning{};
  const ssize_t got = ::pread(file, beginning.data(), beginning.size(), 0);
  const auto size = static_cast<std::size_t>(std::max<ssize_t>(0, got));
  if (format_of(std::span(beginning).first(size)) != RecordingFormat::kCapture)
    return tims::Error(tims::Errc::kInvalidArgument,
                       path + " exists and is not a recording: not overwritten");
  ::lseek(file, 0, SEEK_END);
  return std::optional(end_of(file, status.st_size, status.st_mtim));
}

}  // namespace

Result<std::unique_ptr<CaptureFile>> CaptureFile::create(const std::string& path,
                                                         std::string_view device,
                                                         tims::Time begin) {
  File file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!file) return tims::os::system_error(path);
  const auto before = continued(file.get(), path);
  if (!before) return before.error();
  if (*before) begin -= (*before)->time;
  auto capture = std::unique_ptr<CaptureFile>(new CaptureFile(std::move(file), path, begin));
  std::string header = capture_header(device, tims::base::rfc3339(tims::os::wall_now()));
  if (*before && (*before)->is_cut) header.insert(0, "\n");
  capture->append(header.size(), [&](std::string& text) { text += header; });
  return capture;
}

CaptureFile::CaptureFile(File file, std::string path, tims::Time begin)
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
    on_written(text, write_all(text));
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
  if (lost_ == told_ || (!ended_ && (!written || text.empty()))) return;
  event_ = path_ + (written ? " is written again; " : " could not be written; ") +
           std::to_string(lost_ - told_) + " records are missing in it";
  told_ = lost_;
  failed_ = !written;
}

// Writes whole records: what a full disk accepted only in part is truncated again.
Result<void> CaptureFile::write_all(std::string_view text) {
  const off_t begin = ::lseek(file_.get(), 0, SEEK_CUR);
  while (!text.empty()) {
    const ssize_t size = ::write(file_.get(), text.data(), text.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) {
      auto error = tims::os::system_error(path_);
      (void)::ftruncate(file_.get(), begin);
      ::lseek(file_.get(), begin, SEEK_SET);
      return error;
    }
    text.remove_prefix(static_cast<std::size_t>(size));
  }
  // EINVAL: the file is a pipe or /dev/null.
  if (::fdatasync(file_.get()) != 0 && errno != EINVAL) return tims::os::system_error(path_);
  return {};
}

}  // namespace rack::device

#include "devices/io/capture_file.h"

#include <algorithm>
#include <cerrno>

#include <fcntl.h>
#include <unistd.h>

#include "base/measure.h"
#include "os/clock.h"

namespace rack::device {
namespace {

using tims::Result;
using tims::os::File;

constexpr std::size_t kWaitingMax = 8 << 20;
constexpr auto kWriteEvery = std::chrono::seconds(1);  // what a loss of power may cost
constexpr std::size_t kRecordOverhead = 48;

}  // namespace

Result<std::unique_ptr<CaptureFile>> CaptureFile::create(const std::string& path,
                                                         std::string_view device,
                                                         tims::Time begin) {
  File file(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (!file) return tims::os::system_error(path);
  auto capture = std::unique_ptr<CaptureFile>(new CaptureFile(std::move(file), begin));
  const std::string header = capture_header(device, tims::base::rfc3339(tims::os::wall_now()));
  capture->append(header.size(), [&](std::string& text) { text += header; });
  return capture;
}

CaptureFile::CaptureFile(File file, tims::Time begin) : file_(std::move(file)), begin_(begin) {
  waiting_.reserve(kWaitingMax);
  writer_ = std::thread([this] { write_until_ended(); });
}

CaptureFile::~CaptureFile() {
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
}

void CaptureFile::add(tims::Time when, Direction direction, std::uint32_t id,
                      std::span<const std::byte> bytes) {
  append(2 * bytes.size() + kRecordOverhead,
         [&](std::string& text) { append_record(text, when - begin_, direction, id, bytes); });
}

void CaptureFile::add_event(tims::Time when, std::string_view event) {
  append(4 * event.size() + kRecordOverhead,
         [&](std::string& text) { append_event(text, when - begin_, event); });
}

std::uint64_t CaptureFile::lost() const {
  const std::lock_guard lock(mutex_);
  return lost_;
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
    if (write_all(text)) continue;
    const std::lock_guard lock(mutex_);
    lost_ += static_cast<std::uint64_t>(std::ranges::count(text, '\n'));
  }
}

// Whole records, or none: what a full disk did not take goes again.
bool CaptureFile::write_all(std::string_view text) {
  const off_t begin = ::lseek(file_.get(), 0, SEEK_CUR);
  while (!text.empty()) {
    const ssize_t size = ::write(file_.get(), text.data(), text.size());
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) {
      (void)::ftruncate(file_.get(), begin);
      ::lseek(file_.get(), begin, SEEK_SET);
      return false;
    }
    text.remove_prefix(static_cast<std::size_t>(size));
  }
  return ::fdatasync(file_.get()) == 0;
}

}  // namespace rack::device

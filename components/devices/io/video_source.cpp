// Transport of videos: files, folders of pictures, streams of cameras in the network (RTSP, HTTP),
// pipelines of GStreamer. Another process reads and decodes them (video_source.h).
//
//   rtsp://192.168.0.90/stream1     http://192.168.0.90/video.mjpg     gstreamer:PIPELINE
//   file:corridor.mp4?loop=1&speed=2     file:pictures?rate=10
//
// Arrivals are as those of V4L2 cameras (core/video_frame.h): JPEG as it is in the source if it has
// motion JPEG, BGR otherwise. Frames of a stream have the time of their arrival, and a slow reader
// receives the newest. Frames of a file come at their own rate and none is left out; `rate` sets
// it, and is that of pictures in a folder, `speed` is a factor or "max".
#include "components/devices/io/video_source.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <optional>
#include <utility>
#include <vector>

#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include "components/devices/io/reader_log.h"
#include "components/devices/io/transports.h"
#include "components/devices/io/video_exchange.h"
#include "os/clock.h"
#include "os/file.h"
#include "os/process.h"
#include "os/wakeup.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;
using tims::os::File;
using tims::os::Process;
using tims::os::system_error;

// From the start to the first frame: cameras may send their first key frame after some seconds.
constexpr Duration kOpenWithin = std::chrono::seconds(10);
// Without a frame, a stream is lost: networks and cameras may pause for a moment.
constexpr Duration kStreamPauseMax = std::chrono::seconds(2);
// For the reader to say good-bye to the camera.
constexpr Duration kEndWithin = std::chrono::milliseconds(300);
constexpr off_t kLogBytesMax = 1 << 20;
constexpr int kNotesMax = 64;  // in one call

struct Reader {
  Process process;
  File socket;
  File log;
};

Result<Reader> start_reader(const DeviceAddress& address, int memory) {
  const std::string text = address.to_string();
  if (text.size() > kVideoNoteBytesMax)
    return Error(Errc::kTooBig, "the address of the video has more than 16 KiB");
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0)
    return system_error("cannot create the socket of the video reader");
  File own(ends[0]);
  const File other(ends[1]);
  File log(::memfd_create("video-log", MFD_CLOEXEC));
  if (!log || ::fcntl(log.get(), F_SETFL, O_APPEND) != 0)
    return system_error("cannot create the log of the video reader");
  auto process = Process::start({.command = {kVideoReaderProgram},
                                 .in = other.get(),
                                 .out = memory,
                                 .err = log.get(),
                                 .own_group = true});
  if (!process)
    return Error(Errc::kSystem, process.error().detail() +
                                    "; it is installed with the components with pictures "
                                    "(RACK_WITH_OPENCV=ON)");
  if (::send(own.get(), text.data(), text.size(), MSG_NOSIGNAL) < 0)
    return system_error("cannot send the address to the video reader");
  return Reader{std::move(*process), std::move(own), std::move(log)};
}

class VideoSource final : public Transport {
 public:
  // `never`: a descriptor that does not become readable.
  VideoSource(const DeviceAddress& address, FrameReader frames, Reader reader, File never)
      : shown_(address.shown()),
        is_file_(address.kind == TransportKind::kFile),
        frames_(std::move(frames)),
        reader_(std::move(reader)),
        never_(std::move(never)),
        deadline_(tims::os::now() + kOpenWithin) {}

  ~VideoSource() override {
    reader_.socket.reset();  // the reader ends
    if (!reader_.process.has_ended(kEndWithin)) reader_.process.signal(SIGKILL);
    (void)reader_.process.reap();
  }

  // The end of the socket stays readable.
  [[nodiscard]] int descriptor() const override {
    return is_over_ ? never_.get() : reader_.socket.get();
  }
  [[nodiscard]] Time next_timeout() const override { return deadline_; }
  [[nodiscard]] std::string description() const override {
    return opened_.empty() ? shown_ : shown_ + " (" + opened_ + ")";
  }
  [[nodiscard]] bool is_recording() const override { return is_file_; }
  [[nodiscard]] bool is_over() const override { return is_over_; }
  [[nodiscard]] Duration pause_max() const override { return kStreamPauseMax; }

  Result<void> receive(Time now, const Receive& receive) override {
    if (is_over_) return {};
    auto noted = take_notes();
    const auto has_frame = take_frame(now, receive);
    if (!has_frame) return has_frame.error();
    if (!noted) return noted;
    if (*has_frame) return {};
    is_over_ = has_ended_;
    if (is_over_) deadline_ = tims::kNever;
    if (now < deadline_) return {};
    return Error(Errc::kTimeout, failed("no picture within 10 s").detail());
  }
  // Its controls are not set from here.
  Result<bool> send(Time, std::span<const std::byte>, std::uint32_t) override { return false; }

 private:
  Result<void> take_notes() {
    std::array<char, kVideoNoteBytesMax> note{};
    for (int i = 0; i < kNotesMax && !has_ended_; ++i) {
      const ssize_t size = ::recv(reader_.socket.get(), note.data(), note.size(), MSG_DONTWAIT);
      if (size < 0 && errno == EINTR) continue;
      if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) break;
      if (size <= 0) return failed("the video reader has crashed");
      const std::string_view text(note.data() + 1, static_cast<std::size_t>(size) - 1);
      switch (static_cast<VideoNote>(note.front())) {
        case VideoNote::kOpened:
          opened_ = text;
          break;
        case VideoNote::kFailed:
          return failed(std::string(text));
        case VideoNote::kEnd:
          has_ended_ = true;
          break;
        case VideoNote::kFrame:
        case VideoNote::kTaken:
          break;
      }
    }
    trim_log();
    return {};
  }

  Result<bool> take_frame(Time now, const Receive& receive) {
    VideoFrame frame;
    const auto taken = frames_.take(frame, bytes_);
    if (!taken) return failed(taken.error().detail());
    if (!*taken) return false;
    deadline_ = tims::kNever;
    const Time when = std::min(frame.when, now);
    if (frame.head != head_) {
      head_ = frame.head;
      receive({.bytes = device::bytes_of(*head_), .first = when, .last = when, .id = video::kHead});
    }
    receive({.bytes = bytes_, .first = when, .last = when, .id = head_->format});
    const char note = static_cast<char>(VideoNote::kTaken);
    (void)::send(reader_.socket.get(), &note, 1, MSG_NOSIGNAL | MSG_DONTWAIT);
    return true;
  }

  // With the reason that the libraries have printed.
  [[nodiscard]] Error failed(const std::string& what) const {
    constexpr std::size_t kTailMax = 64 << 10;
    std::string text(kTailMax, '\0');
    struct stat status {};
    ::fstat(reader_.log.get(), &status);
    const off_t begin = std::max<off_t>(0, status.st_size - static_cast<off_t>(kTailMax));
    const ssize_t size = ::pread(reader_.log.get(), text.data(), text.size(), begin);
    text.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
    const std::string reason = reason_in_log(text);
    return {Errc::kSystem, shown_ + ": " + what + (reason.empty() ? "" : ": " + reason)};
  }

  // Some decoders print a line for each damaged frame.
  void trim_log() const {
    struct stat status {};
    if (::fstat(reader_.log.get(), &status) == 0 && status.st_size > kLogBytesMax)
      (void)!::ftruncate(reader_.log.get(), 0);
  }

  std::string shown_;
  bool is_file_;
  FrameReader frames_;
  Reader reader_;
  File never_;
  Time deadline_;  // of the first frame
  std::string opened_;
  std::optional<VideoHead> head_;
  std::vector<std::byte> bytes_;
  bool has_ended_ = false;  // the last frame was sent
  bool is_over_ = false;    // and received
};

}  // namespace

Result<std::unique_ptr<Transport>> open_video_source(const DeviceAddress& address) {
  auto frames = FrameReader::create();
  if (!frames) return frames.error();
  auto never = tims::os::make_event_fd();
  if (!never) return never.error();
  auto reader = start_reader(address, frames->memory());
  if (!reader) return reader.error();
  return std::unique_ptr<Transport>(std::make_unique<VideoSource>(
      address, std::move(*frames), std::move(*reader), std::move(*never)));
}

}  // namespace rack::device

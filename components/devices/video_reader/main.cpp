// rack-video-reader: reads a video for a driver (io/video_source.h says why in a process of its
// own). Started by the driver only.
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>

#include <sched.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "components/devices/io/video_exchange.h"
#include "components/devices/video_reader/employer.h"
#include "components/devices/video_reader/looped_source.h"
#include "components/devices/video_reader/pacing.h"
#include "components/pictures/opencv_call.h"
#include "os/clock.h"

namespace rack::device {
namespace {

// A video of 4096 x 2304 pixels needs a quarter of it; a damaged one could ask for any size.
constexpr rlim_t kMemoryMax = rlim_t{2} << 30;

void become_modest() {
  // The driver may have a real-time priority, decoders must not.
  const sched_param none{};
  ::sched_setscheduler(0, SCHED_OTHER, &none);
  ::signal(SIGPIPE, SIG_IGN);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const rlimit limit{.rlim_cur = kMemoryMax, .rlim_max = kMemoryMax};
  ::setrlimit(RLIMIT_DATA, &limit);
#endif
  const rlimit no_core{.rlim_cur = 0, .rlim_max = 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  // The reasons of failures, for the driver to find (io/reader_log.h): errors and warnings. What
  // the user has set stays. There is one thread so far.
  ::setenv("OPENCV_FFMPEG_DEBUG", "1", 0);      // NOLINT(concurrency-mt-unsafe)
  ::setenv("OPENCV_FFMPEG_LOGLEVEL", "24", 0);  // NOLINT(concurrency-mt-unsafe)
  ::setenv("GST_DEBUG", "2", 0);                // NOLINT(concurrency-mt-unsafe)
  ::setenv("GST_DEBUG_NO_COLOR", "1", 0);       // NOLINT(concurrency-mt-unsafe)
}

Result<std::unique_ptr<FrameSource>> open_source(const DeviceAddress& address) {
  std::error_code none;
  const bool is_folder =
      address.kind == TransportKind::kFile && std::filesystem::is_directory(address.place, none);
  if (address.kind == TransportKind::kFile && !is_folder) {
    // FFmpeg would not state the reason.
    const tims::os::File file(::open(address.place.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file) return tims::Error(tims::Errc::kSystem, std::generic_category().message(errno));
  }
  const LoopedSource::Open open = is_folder ? &open_folder : &open_capture;
  auto source = open(address);
  if (!source || !address.loops()) return source;
  return std::unique_ptr<FrameSource>(
      std::make_unique<LoopedSource>(address, open, std::move(*source)));
}

// Live: newest wins. File: each frame when it is due, and the next when it was taken.
Result<void> read_all(const DeviceAddress& address, FrameSource& source, FrameWriter& frames,
                      Employer& employer) {
  const bool is_file = address.kind == TransportKind::kFile;
  Pacing pacing(address.speed());
  SourceFrame frame;
  while (!employer.is_gone()) {
    const auto got = source.next(frame);
    if (!got) return got.error();
    if (!*got) return {};
    const Time now = tims::os::now();
    const Time when = is_file ? pacing.due(now, frame.media) : now;
    if (is_file) employer.wait_until(when);
    if (is_file) employer.wait_until_taken();
    if (frame.bytes.size() > frames.room().size())
      return tims::Error(tims::Errc::kTooBig, "a frame is too large");
    std::memcpy(frames.room().data(), frame.bytes.data(), frame.bytes.size());
    frames.publish({.head = frame.head, .when = when}, frame.bytes.size());
    employer.send(VideoNote::kFrame);
  }
  return {};
}

Result<void> read_for(Employer& employer, int memory) {
  const auto text = employer.receive_address();
  if (!text) return text.error();
  const auto address = DeviceAddress::parse(*text);
  if (!address) return address.error();
  auto frames = FrameWriter::open(memory);
  if (!frames) return frames.error();
  auto source = open_source(*address);
  if (!source) return source.error();
  employer.send(VideoNote::kOpened, (*source)->description());
  return read_all(*address, **source, *frames, employer);
}

[[noreturn]] void run() {
  become_modest();
  const int memory = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
  ::dup2(STDERR_FILENO, STDOUT_FILENO);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  pictures::use_one_thread();
  Employer employer(STDIN_FILENO);
  const auto read = read_for(employer, memory);
  std::fflush(stdout);
  if (read)
    employer.send(VideoNote::kEnd);
  else
    employer.send(VideoNote::kFailed, read.error().detail());
  // Without destructors: threads of libraries may still run.
  ::_exit(read ? 0 : 1);
}

}  // namespace
}  // namespace rack::device

int main() {
  int type = 0;
  socklen_t size = sizeof type;
  const bool is_started_by_driver =
      ::getsockopt(STDIN_FILENO, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_SEQPACKET;
  if (is_started_by_driver) rack::device::run();
  std::fputs("rack-video-reader is only started by drivers of cameras, for videos and streams\n",
             stderr);
  return 2;
}

// Transport of V4L2 cameras (webcams, depth cameras, grabbers): frames in memory shared with the
// kernel driver, with the time of their capture.
//
//   v4l:/dev/video0?size=640x480&format=MJPG,YUYV&rate=30
//
// format: the first supported one is used; size and rate: the nearest supported ones. The format of
// arrivals is described in core/video_frame.h. A slow reader receives the newest frame. Sending a
// value with the id of a control sets that control.
#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "components/devices/core/video_frame.h"
#include "components/devices/io/transports.h"
#include "components/devices/io/video_request.h"
#include "os/clock.h"
#include "os/file.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;
using tims::os::File;
using tims::os::system_error;

constexpr std::uint32_t kBuffers = 4;  // one is being filled, one waits, one is read, one spare

template <typename Request>
bool control(int file, unsigned long what, Request& request) {
  int result = 0;
  do {
    result = ::ioctl(file, what, &request);
  } while (result < 0 && errno == EINTR);
  return result >= 0;
}

Error in_use(const std::string& path) {
  const int error = errno;
  if (error != EBUSY) return system_error(path);
  return {Errc::kSystem, path + " is used by another program; to find it: fuser " + path};
}

// Opens a device file that delivers pictures: many cameras have a second file for metadata.
Result<File> open_camera(const std::string& path) {
  File file(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (!file) return cannot_open_device(path, "video");
  v4l2_capability can{};
  if (!control(file.get(), VIDIOC_QUERYCAP, can))
    return Error(Errc::kSystem, path + " is not a camera (V4L2)");
  const std::uint32_t of_this =
      (can.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? can.device_caps : can.capabilities;
  constexpr std::uint32_t kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  if ((of_this & kNeeded) != kNeeded)
    return Error(Errc::kSystem, path + " delivers no pictures; the camera may have another number");
  return file;
}

std::vector<std::uint32_t> formats_of(int file) {
  std::vector<std::uint32_t> formats;
  v4l2_fmtdesc format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  for (; control(file, VIDIOC_ENUM_FMT, format); ++format.index)
    formats.push_back(format.pixelformat);
  return formats;
}

Result<v4l2_format> format_for(int file, const std::string& path, const VideoRequest& mode) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (!control(file, VIDIOC_G_FMT, format)) return system_error(path);
  const auto has = formats_of(file);
  const auto chosen = std::ranges::find_first_of(mode.formats, has);
  if (!mode.formats.empty() && chosen == mode.formats.end()) {
    std::string text = path + " supports none of the requested formats; supported:";
    for (const std::uint32_t one : has) text += " " + letters_of(one);
    return Error(Errc::kInvalidArgument, text);
  }
  auto& picture = format.fmt.pix;
  if (!mode.formats.empty()) picture.pixelformat = *chosen;
  if (mode.width != 0) picture.width = mode.width;
  if (mode.height != 0) picture.height = mode.height;
  picture.field = V4L2_FIELD_ANY;
  picture.bytesperline = 0;
  return format;
}

std::string text_of(const v4l2_pix_format& picture) {
  return std::to_string(picture.width) + "x" + std::to_string(picture.height) + " " +
         letters_of(picture.pixelformat);
}

// V4L2 expresses rates as frame intervals. Errors are ignored: some cameras have a fixed rate.
void ask_for_rate(int file, double rate) {
  v4l2_streamparm parameters{};
  parameters.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (rate <= 0 || !control(file, VIDIOC_G_PARM, parameters)) return;
  parameters.parm.capture.timeperframe = {.numerator = 1000,
                                          .denominator = static_cast<std::uint32_t>(rate * 1000)};
  (void)control(file, VIDIOC_S_PARM, parameters);
}

// A buffer of the kernel mapped into this process.
class Mapping {
 public:
  Mapping(void* begin, std::size_t size) : begin_(begin), size_(size) {}
  Mapping(Mapping&& other) noexcept
      : begin_(std::exchange(other.begin_, nullptr)), size_(other.size_) {}
  Mapping& operator=(Mapping&&) = delete;
  ~Mapping() {
    if (begin_ != nullptr) ::munmap(begin_, size_);
  }
  [[nodiscard]] std::span<const std::byte> bytes() const {
    return {static_cast<const std::byte*>(begin_), size_};
  }

 private:
  void* begin_;
  std::size_t size_;
};

class VideoCapture final : public Transport {
 public:
  VideoCapture(File file, std::string path, const v4l2_pix_format& picture)
      : file_(std::move(file)),
        path_(std::move(path)),
        head_{picture.pixelformat, picture.width, picture.height, picture.bytesperline},
        description_(path_ + " " + text_of(picture)) {}
  ~VideoCapture() override {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    (void)control(file_.get(), VIDIOC_STREAMOFF, type);
  }

  Result<void> start() {
    v4l2_requestbuffers request{};
    request.count = kBuffers;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (!control(file_.get(), VIDIOC_REQBUFS, request)) return in_use(path_);
    for (std::uint32_t i = 0; i < request.count; ++i) {
      v4l2_buffer buffer = empty_buffer();
      buffer.index = i;
      if (!control(file_.get(), VIDIOC_QUERYBUF, buffer)) return system_error(path_);
      void* const begin = ::mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE, MAP_SHARED,
                                 file_.get(), buffer.m.offset);
      if (begin == MAP_FAILED) return system_error(path_);
      buffers_.emplace_back(begin, buffer.length);
      if (!control(file_.get(), VIDIOC_QBUF, buffer)) return system_error(path_);
    }
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (!control(file_.get(), VIDIOC_STREAMON, type)) return in_use(path_);
    return {};
  }

  [[nodiscard]] int descriptor() const override { return file_.get(); }
  [[nodiscard]] std::string description() const override { return description_; }

  Result<void> receive(Time now, const Receive& receive) override {
    if (!std::exchange(has_reported_, true)) report_format(now, receive);
    std::optional<v4l2_buffer> newest;
    for (std::uint32_t i = 0; i < 2 * kBuffers; ++i) {
      v4l2_buffer buffer = empty_buffer();
      if (!control(file_.get(), VIDIOC_DQBUF, buffer)) {
        if (errno != EAGAIN) return gone();
        break;
      }
      const bool is_good = (buffer.flags & V4L2_BUF_FLAG_ERROR) == 0 &&
                           buffer.index < buffers_.size() && buffer.bytesused > 0;
      if (!is_good) give_back(buffer);
      if (is_good && newest) give_back(*newest);
      if (is_good) newest = buffer;
    }
    if (!newest) return {};
    const auto bytes = buffers_[newest->index].bytes();
    const Time when = time_of(*newest, now);
    receive({.bytes = bytes.first(std::min<std::size_t>(newest->bytesused, bytes.size())),
             .first = when,
             .last = when,
             .id = head_.format});
    give_back(*newest);
    return {};
  }

  // Sets the control `id` to a value.
  Result<bool> send(Time, std::span<const std::byte> bytes, std::uint32_t id) override {
    const auto value = control_value(bytes);
    if (!value) return false;
    v4l2_control change{.id = id, .value = *value};
    if (control(file_.get(), VIDIOC_S_CTRL, change)) return true;
    if (errno == ENODEV) return gone();
    return false;
  }

 private:
  static v4l2_buffer empty_buffer() {
    v4l2_buffer buffer{};
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    return buffer;
  }
  void give_back(v4l2_buffer buffer) { (void)control(file_.get(), VIDIOC_QBUF, buffer); }

  [[nodiscard]] Error gone() const {
    return {Errc::kSystem, path_ + " is gone: " + system_error("read").detail()};
  }

  // Drivers stamp frames with the monotonic clock; old ones do not, then `now` is used.
  static Time time_of(const v4l2_buffer& buffer, Time now) {
    if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC)
      return now;
    const Time stamp(std::chrono::seconds(buffer.timestamp.tv_sec) +
                     std::chrono::microseconds(buffer.timestamp.tv_usec));
    return std::min(stamp, now);
  }

  void report_format(Time now, const Receive& receive) {
    const VideoBytes head = bytes_of(head_);
    receive({.bytes = head, .first = now, .last = now, .id = video::kHead});
    for (const std::uint32_t id :
         {std::uint32_t{V4L2_CID_BRIGHTNESS}, std::uint32_t{V4L2_CID_GAIN}}) {
      v4l2_queryctrl range{};
      range.id = id;
      v4l2_control value{.id = id, .value = 0};
      if (!control(file_.get(), VIDIOC_QUERYCTRL, range) ||
          (range.flags & (V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY)) != 0 ||
          !control(file_.get(), VIDIOC_G_CTRL, value))
        continue;
      const VideoBytes known =
          bytes_of(VideoControl{id, range.minimum, range.maximum, value.value});
      receive({.bytes = known, .first = now, .last = now, .id = video::kControl});
    }
  }

  File file_;
  std::string path_;
  VideoHead head_;
  std::string description_;
  std::vector<Mapping> buffers_;  // must be destroyed before file_
  bool has_reported_ = false;
};

}  // namespace

Result<std::unique_ptr<Transport>> open_video(const DeviceAddress& address) {
  const std::string& path = address.place;
  const auto mode = video_request(address);
  if (!mode) return mode.error();
  auto file = open_camera(path);
  if (!file) return file.error();
  auto format = format_for(file->get(), path, *mode);
  if (!format) return format.error();
  if (!control(file->get(), VIDIOC_S_FMT, *format)) return in_use(path);
  ask_for_rate(file->get(), mode->rate);
  auto capture = std::make_unique<VideoCapture>(std::move(*file), path, format->fmt.pix);
  if (auto started = capture->start(); !started) return started.error();
  return std::unique_ptr<Transport>(std::move(capture));
}

Result<void> check_video(const DeviceAddress& address) {
  const auto mode = video_request(address);
  if (!mode) return mode.error();
  const auto file = open_camera(address.place);
  if (!file) return file.error();
  auto format = format_for(file->get(), address.place, *mode);
  if (!format) return format.error();
  if (!control(file->get(), VIDIOC_TRY_FMT, *format)) return system_error(address.place);
  const auto& picture = format->fmt.pix;
  if ((mode->width != 0 && picture.width != mode->width) ||
      (mode->height != 0 && picture.height != mode->height))
    return Error(Errc::kInvalidArgument,
                 address.place + " does not support this size; the nearest is " + text_of(picture));
  return {};
}

}  // namespace rack::device

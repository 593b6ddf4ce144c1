#include "components/devices/camera/camera_frames.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

constexpr int kDamagedMax = 30;  // consecutive damaged pictures: more than a transmission error

bool needs_pair(u16 mode, std::uint32_t format) {
  return mode == camera_mode::kDisparity ||
         (mode == camera_mode::kRange && format != video::kDepth16);
}

void put_big_endian(std::vector<std::byte>& bytes, std::size_t i, std::uint32_t number) {
  bytes[2 * i] = static_cast<std::byte>(number >> 8);
  bytes[2 * i + 1] = static_cast<std::byte>(number);
}

}  // namespace

CameraFrames::CameraFrames(const CameraSettings& settings)
    : settings_(settings), maker_(settings.quality), stereo_(settings.stereo) {
  picture_.image.reserve_all();
  if (settings.calibration) rectifier_.emplace(*settings.calibration);
}

void CameraFrames::start(Time now, Output&) {
  clear_failure();
  has_seen_ = false;
  timer_.wait_until(now + settings_.first_within);
  head_ = {};
  brightness_ = {};
  for (const auto& one : controls_) one->start();
  has_picture_ = false;
  due_ = {};
  damaged_in_a_row_ = 0;
}

void CameraFrames::on_timeout(Time now, Output&) {
  if (!timer_.take_due(now)) return;
  fail(Errc::kTimeout, damaged_in_a_row_ > 0
                           ? std::string("the camera sends only damaged pictures")
                           : "no picture from the camera within " +
                                 std::to_string(settings_.first_within / std::chrono::seconds(1)) +
                                 " s");
}

void CameraFrames::on_arrival(const Arrival& arrival, Output& out) {
  if (arrival.id == video::kHead) {
    head_ = video_head(arrival.bytes).value_or(VideoHead{});
    return;
  }
  if (arrival.id == video::kControl) {
    const auto control = video_control(arrival.bytes);
    if (!control || control->max <= control->min) return;
    if (brightness_.id == 0 && controls_.empty()) brightness_ = *control;
    for (const auto& one : controls_) one->on_control(*control, out);
    return;
  }
  if (failure() || !is_due(arrival.last)) return;
  const auto made = make(arrival);
  if (made) {
    damaged_in_a_row_ = 0;
    has_picture_ = has_seen_ = true;
    timer_.stop();
    recorded_ = arrival.last;
    keep_bright(out);
    if (const auto pixels = pixels_of(head_, arrival.bytes))
      for (const auto& one : controls_) one->on_frame(*pixels, out);
    return;
  }
  ++damaged_;
  ++damaged_in_a_row_;
  if (made.error().code() != Errc::kMalformed || damaged_in_a_row_ == kDamagedMax)
    fail(made.error().code(), "the camera: " + made.error().detail());
}

// Accepts frames up to a quarter of a period early, because the camera determines their timing.
bool CameraFrames::is_due(Time when) {
  if (settings_.period == Duration(0)) return true;
  if (when + settings_.period / 4 < due_) return false;
  const bool is_late = when > due_ + settings_.period;
  due_ = (is_late ? when : due_) + settings_.period;
  return true;
}

Result<void> CameraFrames::make(const Arrival& frame) {
  // JPEG contains its size, so that a recording of it may start without a header.
  VideoHead head = head_;
  if (frame.id == video::kMjpeg || frame.id == video::kJpeg) head.format = frame.id;
  if (head.format != frame.id)
    return Error(Errc::kMalformed, "frame of format " + letters_of(frame.id) + " without a header");
  if (rectifier_) {
    const auto rectified = rectifier_->rectify(head, frame.bytes, settings_.mode);
    if (!rectified) return rectified.error();
    return maker_.make(rectified->head, rectified->bytes, settings_.mode, picture_);
  }
  if (!needs_pair(settings_.mode, head.format))
    return maker_.make(head, frame.bytes, settings_.mode, picture_, settings_.thinning);
  if (auto grey = maker_.make(head, frame.bytes, camera_mode::kMono8, pair_); !grey) return grey;
  return make_depth(pair_.image);
}

Result<void> CameraFrames::make_depth(std::span<const std::byte> pair) {
  if (settings_.mode == camera_mode::kRange && (settings_.focal <= 0 || settings_.base <= 0))
    return Error(Errc::kInvalidArgument,
                 "not a depth camera; for a stereo camera set fx and stereoBase");
  const int width = pair_.width / 2;
  const int height = pair_.height;
  if (pair_.width % 2 != 0)
    return Error(Errc::kInvalidArgument, "side-by-side stereo pictures must have an even width");
  constexpr double kFraction = 16;
  auto depths = stereo_.match(pair, width, height);
  if (depths && settings_.mode == camera_mode::kRange)
    depths = stereo_.ranges(settings_.focal * settings_.base * kFraction);
  if (!depths) return depths.error();
  picture_.image.resize(2 * depths->size());
  for (std::size_t i = 0; i < depths->size(); ++i) put_big_endian(picture_.image, i, (*depths)[i]);
  picture_.width = static_cast<u16>(width);
  picture_.height = static_cast<u16>(height);
  picture_.depth = depth_of(settings_.mode);
  picture_.mode = settings_.mode;
  picture_.colorFilterId = 0;
  return {};
}

void CameraFrames::keep_bright(Output& out) {
  if (brightness_.id == 0 || settings_.brightness_part == 0) return;
  const auto bright = brightness_of(picture_, settings_.brightness_part);
  if (!bright) return;
  const int missing = *bright < settings_.brightness_min   ? settings_.brightness_min - *bright
                      : *bright > settings_.brightness_max ? settings_.brightness_max - *bright
                                                           : 0;
  if (missing == 0) return;
  const double range = static_cast<double>(brightness_.max) - brightness_.min;
  const double step = range * missing / 255 * settings_.brightness_gain / 1000;
  const double wanted = brightness_.value + (missing > 0 ? std::ceil(step) : std::floor(step));
  const auto value = static_cast<std::int32_t>(std::clamp(
      wanted, static_cast<double>(brightness_.min), static_cast<double>(brightness_.max)));
  if (value == brightness_.value) return;
  brightness_.value = value;
  out.send(control_bytes(value), brightness_.id);
}

bool CameraFrames::take(CameraData& data, Time& recorded) {
  if (!std::exchange(has_picture_, false)) return false;
  std::swap(data, picture_);
  recorded = recorded_;
  return true;
}

}  // namespace rack::device

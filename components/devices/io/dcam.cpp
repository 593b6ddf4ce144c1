// Transport of IIDC cameras (FireWire, and USB cameras with the same registers) by libdc1394:
// frames in DMA buffers, with the time of their reception.
//
//   dcam:00b09d0100a1b2c3?size=640x480&format=UYVY,GREY&rate=15&speed=400
//   dcam:0
//
// The first format that the camera has in this size is used; rate: the next higher one of the
// camera; speed: of the bus [Mbit/s]. The format of arrivals is described in core/video_frame.h. A
// slow reader receives the newest frame; corrupt frames are dropped. Sending a value with the id of
// a control sets that control.
#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <dc1394/dc1394.h>
#include <poll.h>

#include "base/text.h"
#include "components/devices/core/video_frame.h"
#include "components/devices/io/dcam_modes.h"
#include "components/devices/io/transports.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

constexpr std::uint32_t kBuffers = 4;  // one is being filled, one waits, one is read, one spare
constexpr int kCorruptMax = 30;        // consecutive corrupt frames: more than a disturbance
constexpr std::int32_t kSpeed = 400;   // Mbit/s; all cameras have it

using Context = std::unique_ptr<dc1394_t, decltype(&dc1394_free)>;
using Camera = std::unique_ptr<dc1394camera_t, decltype(&dc1394_camera_free)>;

// The library writes its reasons to stderr; here they are part of the errors.
class LibraryLog {
 public:
  static void clear() {
    static const bool is_registered = [] {
      dc1394_log_register_handler(DC1394_LOG_ERROR, &LibraryLog::keep, nullptr);
      dc1394_log_register_handler(DC1394_LOG_WARNING, nullptr, nullptr);
      return true;
    }();
    (void)is_registered;
    last().clear();
  }
  static std::string text() {
    std::string text = tims::base::printable(last());
    while (!text.empty() && (text.back() == ' ' || text.back() == '\n')) text.pop_back();
    return text.empty() ? text : " (" + text + ")";
  }

 private:
  static std::string& last() {
    static thread_local std::string text;
    return text;
  }
  static void keep(dc1394log_t, const char* message, void*) {
    constexpr std::size_t kTextMax = 200;
    if (message != nullptr) last() = std::string(message).substr(0, kTextMax);
    while (last().ends_with('\n')) last().pop_back();
  }
};

std::string_view advice_for(dc1394error_t error) {
  if (error == DC1394_NO_BANDWIDTH || error == DC1394_NO_ISO_CHANNEL)
    return "; the bus is full: lower the size or the rate, or turn another camera off";
  return "";
}

struct Found {
  Context context;
  Camera camera;
  std::string name;  // "IIDC camera 00b09d0100a1b2c3"
};

Error failed(const std::string& name, std::string_view what, dc1394error_t error) {
  const char* const reason = dc1394_error_get_string(error);
  return {Errc::kSystem, name + ": " + std::string(what) + ": " +
                             (reason == nullptr ? "error " + std::to_string(error) : reason) +
                             LibraryLog::text() + std::string(advice_for(error))};
}

// The GUIDs of all cameras, ascending: a camera that is plugged into another port keeps its number.
Result<std::vector<std::uint64_t>> guids_of(dc1394_t& context) {
  dc1394camera_list_t* list = nullptr;
  const dc1394error_t error = dc1394_camera_enumerate(&context, &list);
  if (error != DC1394_SUCCESS || list == nullptr)
    return failed("IIDC cameras", "cannot list them", error);
  std::vector<std::uint64_t> guids;
  for (const dc1394camera_id_t& id : std::span(list->ids, list->num)) guids.push_back(id.guid);
  dc1394_camera_free_list(list);
  std::ranges::sort(guids);
  guids.erase(std::unique(guids.begin(), guids.end()), guids.end());
  return guids;
}

std::optional<std::uint64_t> wanted_of(std::span<const std::uint64_t> guids,
                                       const std::string& place) {
  constexpr std::size_t kNumberMax = 2;  // digits
  if (place.size() <= kNumberMax) {
    const auto number = tims::base::parse_number<std::size_t>(place);
    if (number && *number < guids.size()) return guids[*number];
    return std::nullopt;
  }
  const auto wanted = tims::base::parse_number<std::uint64_t>(place, 16);
  const bool is_half = place.size() == 8;
  for (const std::uint64_t guid : guids)
    if (wanted == (is_half ? guid & 0xFFFFFFFFU : guid)) return guid;
  return std::nullopt;
}

Result<Found> find_camera(const DeviceAddress& address) {
  LibraryLog::clear();
  Found found{.context = {dc1394_new(), &dc1394_free},
              .camera = {nullptr, &dc1394_camera_free},
              .name = "IIDC camera " + address.place};
  constexpr std::string_view kAdvice =
      "; check that it is plugged in (timsctl device list) and that the user is in the group of "
      "/dev/fw* (video)";
  if (!found.context)
    return Error(Errc::kSystem, found.name + ": no FireWire or USB bus" + LibraryLog::text() +
                                    std::string(kAdvice));
  const auto guids = guids_of(*found.context);
  if (!guids) return guids.error();
  const auto guid = wanted_of(*guids, address.place);
  if (!guid) {
    std::string others;
    for (const std::uint64_t one : *guids) others += " " + guid_text(one);
    return Error(Errc::kSystem,
                 found.name + " is not there" +
                     (others.empty() ? ", nor is any other" : "; there are:" + others) +
                     std::string(kAdvice));
  }
  found.name = "IIDC camera " + guid_text(*guid);
  found.camera.reset(dc1394_camera_new(found.context.get(), *guid));
  if (!found.camera)
    return Error(Errc::kSystem,
                 found.name + " does not answer" + LibraryLog::text() + std::string(kAdvice));
  return found;
}

void add_fixed_mode(dc1394camera_t& camera, dc1394video_mode_t id, std::vector<DcamMode>& modes) {
  DcamMode mode{.id = id};
  dc1394framerates_t rates{};
  if (dc1394_get_color_coding_from_video_mode(&camera, id, &mode.coding) != DC1394_SUCCESS ||
      dc1394_get_image_size_from_video_mode(&camera, id, &mode.width, &mode.height) !=
          DC1394_SUCCESS ||
      dc1394_video_get_supported_framerates(&camera, id, &rates) != DC1394_SUCCESS)
    return;
  for (const dc1394framerate_t rate :
       std::span(rates.framerates).first(std::min<std::size_t>(rates.num, DC1394_FRAMERATE_NUM))) {
    float hertz = 0;
    if (dc1394_framerate_as_float(rate, &hertz) == DC1394_SUCCESS)
      mode.rates.push_back({rate, hertz});
  }
  modes.push_back(std::move(mode));
}

void add_scalable_modes(dc1394camera_t& camera, dc1394video_mode_t id,
                        std::vector<DcamMode>& modes) {
  dc1394format7mode_t info{};
  if (dc1394_format7_get_mode_info(&camera, id, &info) != DC1394_SUCCESS) return;
  const auto count = std::min<std::size_t>(info.color_codings.num, DC1394_COLOR_CODING_NUM);
  for (const dc1394color_coding_t coding : std::span(info.color_codings.codings).first(count))
    modes.push_back({.id = id,
                     .coding = coding,
                     .width = info.max_size_x,
                     .height = info.max_size_y,
                     .width_step = std::max(1U, info.unit_size_x),
                     .height_step = std::max(1U, info.unit_size_y)});
}

Result<DcamChoice> mode_for(const Found& found, const VideoRequest& request) {
  dc1394camera_t& camera = *found.camera;
  dc1394video_modes_t ids{};
  const auto error = dc1394_video_get_supported_modes(&camera, &ids);
  if (error != DC1394_SUCCESS) return failed(found.name, "cannot read its modes", error);
  std::vector<DcamMode> modes;
  for (const dc1394video_mode_t id :
       std::span(ids.modes).first(std::min<std::size_t>(ids.num, DC1394_VIDEO_MODE_NUM))) {
    if (id >= DC1394_VIDEO_MODE_FORMAT7_MIN)
      add_scalable_modes(camera, id, modes);
    else if (id != DC1394_VIDEO_MODE_EXIF)
      add_fixed_mode(camera, id, modes);
  }
  auto chosen = choose_mode(modes, request);
  if (!chosen) return Error(chosen.error().code(), found.name + " " + chosen.error().detail());
  return chosen;
}

Result<dc1394speed_t> speed_of(const DeviceAddress& address) {
  const auto option = address.options.find("speed");
  const std::string text =
      option == address.options.end() ? std::to_string(kSpeed) : option->second;
  constexpr std::array<std::string_view, 6> kSpeeds = {"100", "200", "400", "800", "1600", "3200"};
  const auto* const found = std::ranges::find(kSpeeds, text);
  if (found == kSpeeds.end())
    return Error(Errc::kInvalidArgument,
                 "speed must be 100, 200, 400, 800, 1600 or 3200 Mbit/s, not " + text);
  return static_cast<dc1394speed_t>(DC1394_ISO_SPEED_MIN + (found - kSpeeds.begin()));
}

// The window of a scalable mode is in the middle of the sensor.
dc1394error_t set_window(dc1394camera_t& camera, const DcamChoice& choice, double rate) {
  const dc1394video_mode_t id = choice.mode.id;
  dc1394format7mode_t info{};
  dc1394error_t error = dc1394_format7_get_mode_info(&camera, id, &info);
  const auto in_middle = [](std::uint32_t all, std::uint32_t part, std::uint32_t step) {
    const std::uint32_t middle = (all - std::min(all, part)) / 2;
    return static_cast<std::int32_t>(middle - middle % std::max(1U, step));
  };
  const std::int32_t left = in_middle(info.max_size_x, choice.width, info.unit_pos_x);
  const std::int32_t top = in_middle(info.max_size_y, choice.height, info.unit_pos_y);
  const auto set = [&](std::int32_t packet) {
    return dc1394_format7_set_roi(&camera, id, choice.mode.coding, packet, left, top,
                                  static_cast<std::int32_t>(choice.width),
                                  static_cast<std::int32_t>(choice.height));
  };
  if (error == DC1394_SUCCESS) error = set(DC1394_USE_MAX_AVAIL);
  std::uint32_t step = 0;
  std::uint32_t max = 0;
  std::uint64_t bytes = 0;
  if (error != DC1394_SUCCESS || rate <= 0 ||
      dc1394_format7_get_packet_parameters(&camera, id, &step, &max) != DC1394_SUCCESS ||
      dc1394_format7_get_total_bytes(&camera, id, &bytes) != DC1394_SUCCESS)
    return error;
  return set(static_cast<std::int32_t>(packet_bytes(bytes, rate, step, max)));
}

// --- controls

struct Feature {
  std::uint32_t control;  // video_frame.h
  dc1394feature_t id;
  std::uint32_t automatic;  // the control that turns the camera's own setting on
};
constexpr std::array<Feature, 5> kFeatures = {{
    {video::kShutter, DC1394_FEATURE_SHUTTER, video::kAutoGain},
    {video::kGain, DC1394_FEATURE_GAIN, video::kAutoGain},
    {0, DC1394_FEATURE_EXPOSURE, video::kAutoGain},  // the aim of the camera's own setting
    {video::kBlueBalance, DC1394_FEATURE_WHITE_BALANCE, video::kAutoWhiteBalance},
    {video::kRedBalance, DC1394_FEATURE_WHITE_BALANCE, video::kAutoWhiteBalance},
}};

bool has_mode(const dc1394feature_info_t& info, dc1394feature_mode_t mode) {
  const auto count = std::min<std::size_t>(info.modes.num, DC1394_FEATURE_MODE_NUM);
  return std::ranges::count(std::span(info.modes.modes).first(count), mode) > 0;
}

std::optional<dc1394feature_info_t> feature_info(dc1394camera_t& camera, dc1394feature_t id) {
  dc1394feature_info_t info{};
  info.id = id;
  if (dc1394_feature_get(&camera, &info) != DC1394_SUCCESS || info.available == DC1394_FALSE)
    return std::nullopt;
  return info;
}

std::int32_t number(std::uint32_t value) {
  constexpr std::uint32_t kMax = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(std::min(value, kMax));
}

class Controls {
 public:
  explicit Controls(dc1394camera_t& camera) : camera_(camera) {}

  // The automatic settings first, so that they do not change values that are set afterwards. All
  // are read before the first is reported: the receiver may set them at once.
  void report(Time now, const Transport::Receive& receive) {
    std::vector<VideoControl> all;
    for (const std::uint32_t automatic : {video::kAutoGain, video::kAutoWhiteBalance})
      if (const auto is_on = automatic_state(automatic))
        all.push_back({automatic, 0, 1, *is_on ? 1 : 0});
    for (const Feature& feature : kFeatures)
      if (const auto info = manual_info(feature))
        all.push_back({feature.control, number(info->min), number(info->max),
                       number(value_of(feature.control, *info))});
    for (const VideoControl& control : all) {
      const VideoBytes bytes = bytes_of(control);
      receive({.bytes = bytes, .first = now, .last = now, .id = video::kControl});
    }
  }

  // Returns whether the camera has accepted the value.
  bool set(std::uint32_t control, std::int32_t value) {
    if (control == video::kAutoGain || control == video::kAutoWhiteBalance)
      return set_automatic(control, value != 0);
    const auto* const feature = std::ranges::find(kFeatures, control, &Feature::control);
    if (control == 0 || feature == kFeatures.end() || value < 0) return false;
    dc1394feature_mode_t mode{};
    if (dc1394_feature_get_mode(&camera_, feature->id, &mode) == DC1394_SUCCESS &&
        mode != DC1394_FEATURE_MODE_MANUAL)
      (void)dc1394_feature_set_mode(&camera_, feature->id, DC1394_FEATURE_MODE_MANUAL);
    const auto setting = static_cast<std::uint32_t>(value);
    if (feature->id != DC1394_FEATURE_WHITE_BALANCE)
      return dc1394_feature_set_value(&camera_, feature->id, setting) == DC1394_SUCCESS;
    (control == video::kBlueBalance ? blue_ : red_) = setting;
    return dc1394_feature_whitebalance_set_value(&camera_, blue_, red_) == DC1394_SUCCESS;
  }

 private:
  // Turns a feature on whose value can be set; empty if it cannot.
  std::optional<dc1394feature_info_t> manual_info(const Feature& feature) {
    if (feature.control == 0) return std::nullopt;
    const auto info = feature_info(camera_, feature.id);
    if (!info || !has_mode(*info, DC1394_FEATURE_MODE_MANUAL)) return std::nullopt;
    if (info->on_off_capable == DC1394_TRUE && info->is_on == DC1394_OFF)
      (void)dc1394_feature_set_power(&camera_, feature.id, DC1394_ON);
    return info;
  }

  // Blue and red are one feature of the camera, which is set as a whole.
  std::uint32_t value_of(std::uint32_t control, const dc1394feature_info_t& info) {
    if (control == video::kBlueBalance) return blue_ = info.BU_value;
    if (control == video::kRedBalance) return red_ = info.RV_value;
    return info.value;
  }

  // Empty: no feature of this kind has both settings.
  std::optional<bool> automatic_state(std::uint32_t automatic) {
    std::optional<bool> state;
    for (const Feature& feature : kFeatures) {
      if (feature.automatic != automatic || feature.control == 0) continue;
      const auto info = feature_info(camera_, feature.id);
      if (info && has_mode(*info, DC1394_FEATURE_MODE_AUTO))
        state = state.value_or(false) || info->current_mode == DC1394_FEATURE_MODE_AUTO;
    }
    return state;
  }

  bool set_automatic(std::uint32_t automatic, bool on) {
    const auto mode = on ? DC1394_FEATURE_MODE_AUTO : DC1394_FEATURE_MODE_MANUAL;
    bool is_set = false;
    for (const Feature& feature : kFeatures) {
      if (feature.automatic != automatic) continue;
      const auto info = feature_info(camera_, feature.id);
      if (info && has_mode(*info, mode))
        is_set |= dc1394_feature_set_mode(&camera_, feature.id, mode) == DC1394_SUCCESS;
    }
    return is_set;
  }

  dc1394camera_t& camera_;
  std::uint32_t blue_ = 0;
  std::uint32_t red_ = 0;
};

// --- frames

VideoHead head_of(const dc1394video_frame_t& frame) {
  std::uint32_t format = format_of(frame.color_coding, frame.color_filter);
  if (frame.little_endian == DC1394_TRUE) format &= ~video::kBigEndian;
  return {format, frame.size[0], frame.size[1], frame.stride};
}

class DcamCapture final : public Transport {
 public:
  DcamCapture(Found found, const DcamChoice& choice)
      : context_(std::move(found.context)),
        camera_(std::move(found.camera)),
        name_(std::move(found.name)),
        controls_(*camera_) {
    const auto text = [](const char* one) {
      return one == nullptr ? "" : tims::base::printable(one);
    };
    description_ = name_ + " (" + text(camera_->vendor) + " " + text(camera_->model) + ") " +
                   std::to_string(choice.width) + "x" + std::to_string(choice.height);
  }
  ~DcamCapture() override {
    (void)dc1394_video_set_transmission(camera_.get(), DC1394_OFF);
    if (is_set_up_) (void)dc1394_capture_stop(camera_.get());
  }

  Result<void> start(const DcamChoice& choice, dc1394speed_t speed, double rate) {
    stop_old_transmission();
    dc1394camera_t* const camera = camera_.get();
    const bool is_fast = speed >= DC1394_ISO_SPEED_800;
    const dc1394error_t operation = dc1394_video_set_operation_mode(
        camera, is_fast ? DC1394_OPERATION_MODE_1394B : DC1394_OPERATION_MODE_LEGACY);
    if (is_fast && operation != DC1394_SUCCESS)
      return failed(name_, "has no speeds above 400 Mbit/s", operation);
    if (const auto error = dc1394_video_set_iso_speed(camera, speed))
      return failed(name_, "cannot set the speed of the bus", error);
    if (const auto error = dc1394_video_set_mode(camera, choice.mode.id))
      return failed(name_, "cannot set the mode", error);
    const auto error = choice.mode.is_scalable()
                           ? set_window(*camera, choice, rate)
                           : dc1394_video_set_framerate(camera, choice.rate.id);
    if (error != DC1394_SUCCESS) return failed(name_, "cannot set the size or the rate", error);
    if (const auto setup = dc1394_capture_setup(camera, kBuffers, DC1394_CAPTURE_FLAGS_DEFAULT))
      return failed(name_, "cannot capture", setup);
    is_set_up_ = true;
    if (const auto on = dc1394_video_set_transmission(camera, DC1394_ON))
      return failed(name_, "cannot start", on);
    return {};
  }

  [[nodiscard]] int descriptor() const override { return dc1394_capture_get_fileno(camera_.get()); }
  [[nodiscard]] std::string description() const override { return description_; }
  std::optional<std::string> take_event() override { return std::exchange(event_, {}); }
  [[nodiscard]] std::string statistics() const override {
    return corrupt_ == 0 ? "" : std::to_string(corrupt_) + " corrupt frames";
  }

  Result<void> receive(Time now, const Receive& receive) override {
    if (!std::exchange(has_reported_, true)) controls_.report(now, receive);
    dc1394video_frame_t* newest = nullptr;
    for (std::uint32_t i = 0; i < 2 * kBuffers; ++i) {
      LibraryLog::clear();
      dc1394video_frame_t* frame = nullptr;
      if (const auto error =
              dc1394_capture_dequeue(camera_.get(), DC1394_CAPTURE_POLICY_POLL, &frame))
        return failed(name_, "is gone", error);
      if (frame == nullptr) break;
      const bool is_corrupt = dc1394_capture_is_frame_corrupt(camera_.get(), frame) == DC1394_TRUE;
      count(is_corrupt);
      dc1394video_frame_t* const unused = is_corrupt ? frame : std::exchange(newest, frame);
      if (unused != nullptr) give_back(*unused);
    }
    if (newest != nullptr) {
      hand_over(*newest, now, receive);
      give_back(*newest);
      return {};
    }
    if (corrupt_in_a_row_ >= kCorruptMax)
      return Error(Errc::kSystem, name_ + " sends only corrupt frames; check its cable and power");
    return has_hung_up() ? Error(Errc::kSystem, name_ + " is gone") : Result<void>();
  }

  // Sets the control `id` to a value.
  Result<bool> send(Time, std::span<const std::byte> bytes, std::uint32_t id) override {
    const auto value = control_value(bytes);
    return value && controls_.set(id, *value);
  }

 private:
  // A camera goes on sending after its program has crashed, and occupies the bus.
  void stop_old_transmission() {
    dc1394switch_t is_on = DC1394_OFF;
    if (dc1394_video_get_transmission(camera_.get(), &is_on) != DC1394_SUCCESS ||
        is_on == DC1394_OFF)
      return;
    (void)dc1394_video_set_transmission(camera_.get(), DC1394_OFF);
    event_ = name_ + " was sending: another program has crashed, or still uses it";
  }

  // The library reports no end: without this, poll() would return again and again.
  [[nodiscard]] bool has_hung_up() const {
    pollfd state{.fd = descriptor(), .events = POLLIN, .revents = 0};
    return ::poll(&state, 1, 0) > 0 && (state.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0 &&
           (state.revents & POLLIN) == 0;
  }

  void count(bool is_corrupt) {
    corrupt_in_a_row_ = is_corrupt ? corrupt_in_a_row_ + 1 : 0;
    if (is_corrupt) ++corrupt_;
  }

  void give_back(dc1394video_frame_t& frame) {
    (void)dc1394_capture_enqueue(camera_.get(), &frame);
  }

  void hand_over(const dc1394video_frame_t& frame, Time now, const Receive& receive) {
    const Time when = time_of(frame, now);
    const VideoHead head = head_of(frame);
    if (std::exchange(head_, head) != head) {
      const VideoBytes bytes = bytes_of(head);
      receive({.bytes = bytes, .first = when, .last = when, .id = video::kHead});
    }
    const std::span<const unsigned char> pixels(frame.image, frame.image_bytes);
    receive({.bytes = std::as_bytes(pixels), .first = when, .last = when, .id = head.format});
  }

  // The library stamps frames with the wall clock, which may be set at any time.
  static Time time_of(const dc1394video_frame_t& frame, Time now) {
    constexpr Duration kAgeMax = std::chrono::seconds(1);
    const auto wall = std::chrono::system_clock::now().time_since_epoch();
    const auto age = wall - std::chrono::microseconds(frame.timestamp);
    return age < Duration(0) || age > kAgeMax ? now
                                              : now - std::chrono::duration_cast<Duration>(age);
  }

  Context context_;  // must be destroyed after the camera
  Camera camera_;
  std::string name_;
  std::string description_;
  Controls controls_;
  VideoHead head_{};
  std::optional<std::string> event_;
  bool is_set_up_ = false;
  bool has_reported_ = false;
  std::uint64_t corrupt_ = 0;
  int corrupt_in_a_row_ = 0;
};

}  // namespace

Result<std::unique_ptr<Transport>> open_dcam(const DeviceAddress& address) {
  const auto request = video_request(address);
  if (!request) return request.error();
  const auto speed = speed_of(address);
  if (!speed) return speed.error();
  auto found = find_camera(address);
  if (!found) return found.error();
  const auto choice = mode_for(*found, *request);
  if (!choice) return choice.error();
  auto capture = std::make_unique<DcamCapture>(std::move(*found), *choice);
  if (auto started = capture->start(*choice, *speed, request->rate); !started)
    return started.error();
  return std::unique_ptr<Transport>(std::move(capture));
}

Result<void> check_dcam(const DeviceAddress& address) {
  const auto request = video_request(address);
  if (!request) return request.error();
  auto found = find_camera(address);
  if (!found) return found.error();
  const auto choice = mode_for(*found, *request);
  if (!choice) return choice.error();
  return {};
}

}  // namespace rack::device

// Stand-in for libdc1394: the functions that RACK calls, with a camera that exists only here. Built
// as libdc1394.so.25, it is loaded instead of the library by programs that are started with its
// folder in LD_LIBRARY_PATH, and by tests that are linked to it.
//
// The file named by DC1394_STAND_IN describes what happens, and is read again for each frame: lines
// "name number", see Scene. What the program has set is written to that file with ".state" added.
// Tests write and read them by dc1394_scene.h.
//
// The camera sees a grey ramp that becomes brighter with shutter and gain, and a card at the upper
// edge, which is grey at blue=132, red=118. In the other pixels there is a red and a blue half.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <dc1394/dc1394.h>
#include <sys/timerfd.h>
#include <unistd.h>

// The library's type, of which its header only knows the name.
struct __dc1394_t {};  // NOLINT(bugprone-reserved-identifier,cert-dcl*)

namespace {

constexpr std::uint32_t kSensorWidth = 1388;
constexpr std::uint32_t kSensorHeight = 1038;
constexpr std::uint32_t kPacketStep = 4;
constexpr std::uint32_t kPacketMax = 4096;

// NOLINTNEXTLINE(concurrency-mt-unsafe)
const char* scene_path() { return std::getenv("DC1394_STAND_IN"); }

struct Scene {
  std::map<std::string, int> values;

  // bus: 0 there is none; plugged: 0 no camera; hang: 1 no frames; corrupt: n every n-th frame is;
  // broken: 1 reading fails; full: 1 the bus is; small: 1 no mode above 640x480; sending: 1 it has
  // been sending before; light: 100 is normal; cameras: how many; old: 1 frames without time
  // stamps.
  [[nodiscard]] int number(const std::string& name, int otherwise) const {
    const auto found = values.find(name);
    return found == values.end() ? otherwise : found->second;
  }
  static Scene read() {
    Scene scene;
    const char* const path = scene_path();
    std::ifstream file(path == nullptr ? "" : path);
    std::string name;
    for (int value = 0; file >> name >> value;) scene.values[name] = value;
    return scene;
  }
};

struct Feature {
  std::uint32_t min;
  std::uint32_t max;
  std::uint32_t value;
  dc1394feature_mode_t mode = DC1394_FEATURE_MODE_AUTO;
};

struct Camera : dc1394camera_t {
  dc1394video_mode_t video_mode = DC1394_VIDEO_MODE_640x480_YUV422;
  dc1394framerate_t rate = DC1394_FRAMERATE_15;
  dc1394color_coding_t coding = DC1394_COLOR_CODING_YUV422;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t left = 0;
  std::uint32_t top = 0;
  std::uint32_t packet = 0;
  bool is_sending = false;
  int file = -1;  // a timer
  int frames = 0;
  std::map<dc1394feature_t, Feature> features{
      {DC1394_FEATURE_SHUTTER, {1, 4095, 1000}},
      {DC1394_FEATURE_GAIN, {192, 1023, 192}},
      {DC1394_FEATURE_EXPOSURE, {0, 1023, 400}},
  };
  std::uint32_t blue = 90;
  std::uint32_t red = 90;
  dc1394feature_mode_t white = DC1394_FEATURE_MODE_AUTO;
  std::vector<unsigned char> pixels;
  dc1394video_frame_t frame{};
  bool is_out = false;  // the frame was dequeued
};

Camera& own(dc1394camera_t* camera) { return *static_cast<Camera*>(camera); }

void note(const Camera& camera) {
  const char* const path = scene_path();
  if (path == nullptr) return;
  const auto value = [&](dc1394feature_t id) { return camera.features.at(id).value; };
  const std::string name = std::string(path) + ".state";
  std::ofstream(name + ".new")
      << "mode " << camera.video_mode << "\nrate " << camera.rate << "\nwidth " << camera.width
      << "\nheight " << camera.height << "\nleft " << camera.left << "\ntop " << camera.top
      << "\npacket " << camera.packet << "\nsending " << camera.is_sending << "\nshutter "
      << value(DC1394_FEATURE_SHUTTER) << "\ngain " << value(DC1394_FEATURE_GAIN) << "\nautogain "
      << (camera.features.at(DC1394_FEATURE_GAIN).mode == DC1394_FEATURE_MODE_AUTO)
      << "\nautoshutter "
      << (camera.features.at(DC1394_FEATURE_SHUTTER).mode == DC1394_FEATURE_MODE_AUTO) << "\nblue "
      << camera.blue << "\nred " << camera.red << "\nautowhite "
      << (camera.white == DC1394_FEATURE_MODE_AUTO) << "\n";
  ::rename((name + ".new").c_str(), name.c_str());
}

struct Mode {
  dc1394video_mode_t id;
  dc1394color_coding_t coding;
  std::uint32_t width;
  std::uint32_t height;
};
constexpr std::array<Mode, 9> kModes = {{
    {DC1394_VIDEO_MODE_320x240_YUV422, DC1394_COLOR_CODING_YUV422, 320, 240},
    {DC1394_VIDEO_MODE_640x480_YUV411, DC1394_COLOR_CODING_YUV411, 640, 480},
    {DC1394_VIDEO_MODE_640x480_YUV422, DC1394_COLOR_CODING_YUV422, 640, 480},
    {DC1394_VIDEO_MODE_640x480_RGB8, DC1394_COLOR_CODING_RGB8, 640, 480},
    {DC1394_VIDEO_MODE_640x480_MONO8, DC1394_COLOR_CODING_MONO8, 640, 480},
    {DC1394_VIDEO_MODE_640x480_MONO16, DC1394_COLOR_CODING_MONO16, 640, 480},
    {DC1394_VIDEO_MODE_1280x960_YUV422, DC1394_COLOR_CODING_YUV422, 1280, 960},
    {DC1394_VIDEO_MODE_1280x960_MONO8, DC1394_COLOR_CODING_MONO8, 1280, 960},
    {DC1394_VIDEO_MODE_1280x960_MONO16, DC1394_COLOR_CODING_MONO16, 1280, 960},
}};
constexpr std::array kRates = {DC1394_FRAMERATE_3_75, DC1394_FRAMERATE_7_5, DC1394_FRAMERATE_15,
                               DC1394_FRAMERATE_30};
constexpr std::array kCodings = {DC1394_COLOR_CODING_MONO8, DC1394_COLOR_CODING_RAW8,
                                 DC1394_COLOR_CODING_RAW16};

const Mode* find_mode(dc1394video_mode_t id) {
  const auto* const found = std::ranges::find(kModes, id, &Mode::id);
  return found == kModes.end() ? nullptr : found;
}

double hertz_of(dc1394framerate_t rate) {
  return 1.875 * static_cast<double>(1U << static_cast<unsigned>(rate - DC1394_FRAMERATE_MIN));
}

std::uint32_t bits_of(dc1394color_coding_t coding) {
  switch (coding) {
    case DC1394_COLOR_CODING_RGB8:
      return 24;
    case DC1394_COLOR_CODING_YUV422:
    case DC1394_COLOR_CODING_MONO16:
    case DC1394_COLOR_CODING_RAW16:
      return 16;
    default:
      return 8;
  }
}

// --- what the camera sees

struct Colour {
  int red, green, blue;
};

class View {
 public:
  View(const Camera& camera, const Scene& scene)
      : camera_(camera),
        exposure_(scene.number("light", 100) / 100.0 *
                  camera.features.at(DC1394_FEATURE_SHUTTER).value / 1000.0 *
                  camera.features.at(DC1394_FEATURE_GAIN).value / 192.0) {}

  [[nodiscard]] int grey(std::uint32_t x) const {
    return clamp((20 + 180.0 * x / camera_.width) * exposure_);
  }
  [[nodiscard]] Colour colour(std::uint32_t x, std::uint32_t y) const {
    const int level = grey(x);
    return y < camera_.height / 2 ? Colour{level, level / 4, level / 4}
                                  : Colour{level / 4, level / 4, level};
  }
  [[nodiscard]] int u() const { return clamp(128 + (static_cast<int>(camera_.blue) - 132) / 2.0); }
  [[nodiscard]] int v() const { return clamp(128 + (static_cast<int>(camera_.red) - 118) / 2.0); }

 private:
  static int clamp(double value) { return static_cast<int>(std::clamp(value, 0.0, 255.0)); }
  const Camera& camera_;
  double exposure_;
};

void render(Camera& camera, const Scene& scene) {
  const View view(camera, scene);
  const std::uint32_t stride = camera.width * bits_of(camera.coding) / 8;
  camera.pixels.resize(std::size_t{stride} * camera.height);
  std::size_t at = 0;
  const auto put = [&](int value) { camera.pixels[at++] = static_cast<unsigned char>(value); };
  for (std::uint32_t y = 0; y < camera.height; ++y)
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      const Colour colour = view.colour(x, y);
      const int raw = y % 2 == 0 ? (x % 2 == 0 ? colour.red : colour.green)
                                 : (x % 2 == 0 ? colour.green : colour.blue);
      switch (camera.coding) {
        case DC1394_COLOR_CODING_YUV422:
          put(x % 2 == 0 ? view.u() : view.v());
          put(view.grey(x));
          break;
        case DC1394_COLOR_CODING_RGB8:
          put(colour.red), put(colour.green), put(colour.blue);
          break;
        case DC1394_COLOR_CODING_MONO16:  // 12 bits, big-endian
          put(view.grey(x) >> 4), put(view.grey(x) << 4 & 0xFF);
          break;
        case DC1394_COLOR_CODING_RAW16:
          put(raw >> 4), put(raw << 4 & 0xFF);
          break;
        case DC1394_COLOR_CODING_RAW8:
          put(raw);
          break;
        default:
          put(view.grey(x));
      }
    }
  using std::chrono::duration_cast;
  const auto wall = std::chrono::system_clock::now().time_since_epoch();
  camera.frame = {};
  camera.frame.image = camera.pixels.data();
  camera.frame.size[0] = camera.width;
  camera.frame.size[1] = camera.height;
  camera.frame.color_coding = camera.coding;
  camera.frame.color_filter = DC1394_COLOR_FILTER_RGGB;
  camera.frame.stride = stride;
  camera.frame.image_bytes = stride * camera.height;
  camera.frame.total_bytes = camera.frame.image_bytes;
  camera.frame.video_mode = camera.video_mode;
  camera.frame.timestamp = scene.number("old", 0) != 0
                               ? 0
                               : static_cast<std::uint64_t>(
                                     duration_cast<std::chrono::microseconds>(wall).count() - 2000);
  camera.frame.camera = &camera;
  camera.frame.little_endian = DC1394_FALSE;
}

void hang_up(int file) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) return;
  ::close(ends[1]);
  ::dup2(ends[0], file);
  ::close(ends[0]);
}

void (*error_handler)(dc1394log_t, const char*, void*) = nullptr;

dc1394error_t failure(dc1394error_t error, const char* text) {
  if (error_handler != nullptr) error_handler(DC1394_LOG_ERROR, text, nullptr);
  return error;
}

}  // namespace

// --- the library's functions

extern "C" {

dc1394_t* dc1394_new() { return Scene::read().number("bus", 1) == 0 ? nullptr : new __dc1394_t; }
void dc1394_free(dc1394_t* dc1394) { delete dc1394; }

dc1394error_t dc1394_camera_enumerate(dc1394_t*, dc1394camera_list_t** list) {
  const Scene scene = Scene::read();
  *list = new dc1394camera_list_t{};
  (*list)->num =
      scene.number("plugged", 1) == 0 ? 0U : static_cast<std::uint32_t>(scene.number("cameras", 1));
  (*list)->ids = new dc1394camera_id_t[(*list)->num + 1]{};
  for (std::uint32_t i = 0; i < (*list)->num; ++i)  // not in order
    (*list)->ids[i].guid = 0x00b09d0100a1b2c3U - i;
  return DC1394_SUCCESS;
}
void dc1394_camera_free_list(dc1394camera_list_t* list) {
  delete[] list->ids;
  delete list;
}

dc1394camera_t* dc1394_camera_new(dc1394_t*, uint64_t guid) {
  const Scene scene = Scene::read();
  if (scene.number("plugged", 1) == 0) return nullptr;
  auto* const camera = new Camera;
  static std::array<char, 8> vendor{"Nobody"};
  static std::array<char, 16> model{"Stand-in\x01"};
  camera->guid = guid;
  camera->vendor = vendor.data();
  camera->model = model.data();
  camera->is_sending = scene.number("sending", 0) != 0;
  return camera;
}
void dc1394_camera_free(dc1394camera_t* camera) { delete &own(camera); }

const char* dc1394_error_get_string(dc1394error_t error) {
  if (error == DC1394_NO_BANDWIDTH) return "No bandwidth";
  return error == DC1394_SUCCESS ? "Success" : "Generic failure";
}
dc1394error_t dc1394_log_register_handler(dc1394log_t type,
                                          void (*handler)(dc1394log_t, const char*, void*), void*) {
  if (type == DC1394_LOG_ERROR) error_handler = handler;
  return DC1394_SUCCESS;
}

// --- modes

dc1394error_t dc1394_get_color_coding_from_video_mode(dc1394camera_t*,
                                                      dc1394video_mode_t video_mode,
                                                      dc1394color_coding_t* color_coding) {
  const Mode* const mode = find_mode(video_mode);
  if (mode == nullptr) return DC1394_INVALID_VIDEO_MODE;
  *color_coding = mode->coding;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_get_image_size_from_video_mode(dc1394camera_t*, dc1394video_mode_t video_mode,
                                                    uint32_t* width, uint32_t* height) {
  const Mode* const mode = find_mode(video_mode);
  if (mode == nullptr) return DC1394_INVALID_VIDEO_MODE;
  *width = mode->width;
  *height = mode->height;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_framerate_as_float(dc1394framerate_t framerate_enum, float* framerate) {
  *framerate = static_cast<float>(hertz_of(framerate_enum));
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_video_get_supported_modes(dc1394camera_t*, dc1394video_modes_t* modes) {
  const bool is_small = Scene::read().number("small", 0) != 0;
  modes->num = 0;
  for (const Mode& mode : kModes)
    if (!is_small || mode.width <= 640) modes->modes[modes->num++] = mode.id;
  if (!is_small) modes->modes[modes->num++] = DC1394_VIDEO_MODE_FORMAT7_0;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_video_get_supported_framerates(dc1394camera_t*, dc1394video_mode_t,
                                                    dc1394framerates_t* rates) {
  rates->num = kRates.size();
  std::ranges::copy(kRates, rates->framerates);
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_format7_get_mode_info(dc1394camera_t*, dc1394video_mode_t,
                                           dc1394format7mode_t* f7_mode) {
  *f7_mode = {};
  f7_mode->present = DC1394_TRUE;
  f7_mode->max_size_x = kSensorWidth;
  f7_mode->max_size_y = kSensorHeight;
  f7_mode->unit_size_x = f7_mode->unit_size_y = f7_mode->unit_pos_x = 2;
  f7_mode->unit_pos_y = 1;
  f7_mode->color_codings.num = kCodings.size();
  std::ranges::copy(kCodings, f7_mode->color_codings.codings);
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_format7_set_roi(dc1394camera_t* camera, dc1394video_mode_t,
                                     dc1394color_coding_t coding, int32_t packet, int32_t left,
                                     int32_t top, int32_t width, int32_t height) {
  Camera& it = own(camera);
  if (left + width > static_cast<int>(kSensorWidth) ||
      top + height > static_cast<int>(kSensorHeight))
    return failure(DC1394_INVALID_ARGUMENT_VALUE, "outside of the sensor\n");
  it.coding = coding;
  it.left = static_cast<std::uint32_t>(left);
  it.top = static_cast<std::uint32_t>(top);
  it.width = static_cast<std::uint32_t>(width);
  it.height = static_cast<std::uint32_t>(height);
  it.packet = packet < 0 ? kPacketMax : static_cast<std::uint32_t>(packet);
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_format7_get_packet_parameters(dc1394camera_t*, dc1394video_mode_t,
                                                   uint32_t* unit, uint32_t* max) {
  *unit = kPacketStep;
  *max = kPacketMax;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_format7_get_total_bytes(dc1394camera_t* camera, dc1394video_mode_t,
                                             uint64_t* bytes) {
  const Camera& it = own(camera);
  *bytes = std::uint64_t{it.width} * it.height * bits_of(it.coding) / 8;
  return DC1394_SUCCESS;
}

dc1394error_t dc1394_video_set_operation_mode(dc1394camera_t*, dc1394operation_mode_t mode) {
  return mode == DC1394_OPERATION_MODE_LEGACY
             ? DC1394_SUCCESS
             : failure(DC1394_FUNCTION_NOT_SUPPORTED, "camera is not capable of 1394B\n");
}
dc1394error_t dc1394_video_set_iso_speed(dc1394camera_t*, dc1394speed_t) { return DC1394_SUCCESS; }
dc1394error_t dc1394_video_set_mode(dc1394camera_t* camera, dc1394video_mode_t video_mode) {
  Camera& it = own(camera);
  it.video_mode = video_mode;
  if (const Mode* const mode = find_mode(video_mode)) {
    it.coding = mode->coding;
    it.width = mode->width;
    it.height = mode->height;
  }
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_video_set_framerate(dc1394camera_t* camera, dc1394framerate_t rate) {
  own(camera).rate = rate;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_video_get_transmission(dc1394camera_t* camera, dc1394switch_t* pwr) {
  *pwr = own(camera).is_sending ? DC1394_ON : DC1394_OFF;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_video_set_transmission(dc1394camera_t* camera, dc1394switch_t pwr) {
  own(camera).is_sending = pwr == DC1394_ON;
  note(own(camera));
  return DC1394_SUCCESS;
}

// --- features

dc1394error_t dc1394_feature_get(dc1394camera_t* camera, dc1394feature_info_t* feature) {
  Camera& it = own(camera);
  const auto found = it.features.find(feature->id);
  const bool is_white = feature->id == DC1394_FEATURE_WHITE_BALANCE;
  feature->available = found != it.features.end() || is_white ? DC1394_TRUE : DC1394_FALSE;
  feature->is_on = DC1394_ON;
  feature->modes.num = 2;
  feature->modes.modes[0] = DC1394_FEATURE_MODE_MANUAL;
  feature->modes.modes[1] = DC1394_FEATURE_MODE_AUTO;
  if (is_white) {
    feature->min = 1;
    feature->max = 255;
    feature->BU_value = it.blue;
    feature->RV_value = it.red;
    feature->current_mode = it.white;
  } else if (found != it.features.end()) {
    feature->min = found->second.min;
    feature->max = found->second.max;
    feature->value = found->second.value;
    feature->current_mode = found->second.mode;
  }
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_feature_get_mode(dc1394camera_t* camera, dc1394feature_t feature,
                                      dc1394feature_mode_t* mode) {
  Camera& it = own(camera);
  *mode = feature == DC1394_FEATURE_WHITE_BALANCE ? it.white : it.features.at(feature).mode;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_feature_set_mode(dc1394camera_t* camera, dc1394feature_t feature,
                                      dc1394feature_mode_t mode) {
  Camera& it = own(camera);
  (feature == DC1394_FEATURE_WHITE_BALANCE ? it.white : it.features.at(feature).mode) = mode;
  note(it);
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_feature_set_power(dc1394camera_t*, dc1394feature_t, dc1394switch_t) {
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_feature_set_value(dc1394camera_t* camera, dc1394feature_t feature,
                                       uint32_t value) {
  Feature& it = own(camera).features.at(feature);
  if (value < it.min || value > it.max) return DC1394_REQ_VALUE_OUTSIDE_RANGE;
  it.value = value;
  note(own(camera));
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_feature_whitebalance_set_value(dc1394camera_t* camera, uint32_t u_b_value,
                                                    uint32_t v_r_value) {
  own(camera).blue = u_b_value;
  own(camera).red = v_r_value;
  note(own(camera));
  return DC1394_SUCCESS;
}

// --- capture

dc1394error_t dc1394_capture_setup(dc1394camera_t* camera, uint32_t, uint32_t) {
  Camera& it = own(camera);
  if (Scene::read().number("full", 0) != 0)
    return failure(DC1394_NO_BANDWIDTH, "Error: could not allocate bandwidth\n");
  it.file = ::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
  const auto period = static_cast<long>(1e9 / hertz_of(it.rate));
  const itimerspec times{.it_interval = {0, period}, .it_value = {0, period}};
  ::timerfd_settime(it.file, 0, &times, nullptr);
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_capture_stop(dc1394camera_t* camera) {
  ::close(own(camera).file);
  own(camera).file = -1;
  return DC1394_SUCCESS;
}
int dc1394_capture_get_fileno(dc1394camera_t* camera) { return own(camera).file; }

dc1394error_t dc1394_capture_dequeue(dc1394camera_t* camera, dc1394capture_policy_t,
                                     dc1394video_frame_t** frame) {
  Camera& it = own(camera);
  *frame = nullptr;
  std::uint64_t ticks = 0;
  if (it.is_out || ::read(it.file, &ticks, sizeof ticks) <= 0) return DC1394_SUCCESS;
  const Scene scene = Scene::read();
  if (scene.number("broken", 0) != 0) return failure(DC1394_IOCTL_FAILURE, "dequeue: no device\n");
  if (scene.number("plugged", 1) == 0) hang_up(it.file);
  if (scene.number("plugged", 1) == 0 || scene.number("hang", 0) != 0) return DC1394_SUCCESS;
  render(it, scene);
  ++it.frames;
  it.is_out = true;
  *frame = &it.frame;
  return DC1394_SUCCESS;
}
dc1394error_t dc1394_capture_enqueue(dc1394camera_t* camera, dc1394video_frame_t*) {
  own(camera).is_out = false;
  return DC1394_SUCCESS;
}
dc1394bool_t dc1394_capture_is_frame_corrupt(dc1394camera_t* camera, dc1394video_frame_t*) {
  const int every = Scene::read().number("corrupt", 0);
  return every > 0 && own(camera).frames % every == 0 ? DC1394_TRUE : DC1394_FALSE;
}

}  // extern "C"

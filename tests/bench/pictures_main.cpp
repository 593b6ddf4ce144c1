// tims-bench-pictures: without arguments, the time of every conversion of pictures of 640 x 480.
// With FOLDER and COUNT, writes pictures as JPEG for the scenario camera_cpu.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "components/devices/camera/camera_frames.h"
#include "components/geometry/pose.h"
#include "components/pictures/jpeg.h"
#include "components/pictures/opencv_call.h"
#include "components/world/render/camera_renderer.h"

namespace tims::bench {
namespace {

using namespace rack::device;
using rack::pictures::Jpeg;
using rack::pictures::PixelLayout;
namespace camera_mode = rack::camera_mode;

constexpr std::uint32_t kWidth = 640;
constexpr std::uint32_t kHeight = 480;

// Moving stripes with noise: about 50 kB per picture as JPEG, as from real cameras.
std::vector<std::byte> stripes(std::size_t channels, std::uint32_t turn) {
  std::vector<std::byte> pixels;
  std::uint32_t noise = 1 + turn;
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x)
      for (std::size_t channel = 0; channel < channels; ++channel) {
        const std::array parts = {x + y, x * 2, y * 3};
        noise = noise * 1664525U + 1013904223U;
        pixels.push_back(
            static_cast<std::byte>((parts.at(channel) / 4 + turn) % 200 + (noise >> 27)));
      }
  return pixels;
}

bool write_pictures(const std::filesystem::path& folder, int count) {
  std::filesystem::create_directories(folder);
  constexpr int kQuality = 80;
  Jpeg jpeg;
  std::vector<std::byte> picture;
  for (int i = 0; i < count; ++i) {
    const auto pixels = stripes(3, static_cast<std::uint32_t>(i));
    const auto made =
        jpeg.encode({.layout = PixelLayout::kRgb, .size = {kWidth, kHeight}, .bytes = pixels},
                    kQuality, pixels.size(), picture);
    if (!made) {
      std::fprintf(stderr, "%s\n", made.error().message().c_str());
      return false;
    }
    const std::string number = std::to_string(i);
    std::ofstream(folder / (std::string(4 - number.size(), '0') + number + ".jpg"),
                  std::ios::binary)
        .write(reinterpret_cast<const char*>(picture.data()),
               static_cast<std::streamsize>(picture.size()));
  }
  return true;
}

double cpu_us() {
  timespec time{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e6 + static_cast<double>(time.tv_nsec) / 1e3;
}

// The lower quartile of some measurements: others disturb only upwards.
template <typename Function>
void measure(const std::string& name, int times, Function function) {
  constexpr std::size_t kMeasurements = 9;
  function();
  std::vector<double> each;
  while (each.size() < kMeasurements) {
    const double before = cpu_us();
    for (int i = 0; i < times; ++i) function();
    each.push_back((cpu_us() - before) / times);
  }
  std::ranges::sort(each);
  std::printf("%-24s %10.1f us\n", name.c_str(), each[kMeasurements / 4]);
}

void check(const Result<void>& made) {
  if (!made) std::printf("  failed: %s\n", made.error().message().c_str());
}

void measure_conversions() {
  PictureMaker maker;
  rack::CameraData picture;
  picture.image.reserve_all();
  constexpr std::array kFormats = {std::pair{video::kGrey, 1},   std::pair{video::kYuyv, 2},
                                   std::pair{video::kUyvy, 2},   std::pair{video::kRgb24, 3},
                                   std::pair{video::kBgr24, 3},  std::pair{video::kGrey16, 2},
                                   std::pair{video::kDepth16, 2}};
  constexpr std::array kModes = {camera_mode::kMono8,  camera_mode::kRgb24, camera_mode::kYuv422,
                                 camera_mode::kMono16, camera_mode::kRange, camera_mode::kJpeg};
  for (const auto& [format, channels] : kFormats)
    for (const rack::u16 mode : kModes) {
      const auto pixels = stripes(static_cast<std::size_t>(channels), 0);
      const VideoHead head{.format = format, .width = kWidth, .height = kHeight};
      if (!maker.make(head, pixels, mode, picture)) continue;
      measure(letters_of(format) + " to " + std::string(name_of_mode(mode)), 40,
              [&] { check(maker.make(head, pixels, mode, picture)); });
    }
  const auto pixels = stripes(3, 0);
  Jpeg encoder;
  std::vector<std::byte> jpeg;
  check(encoder.encode({.layout = PixelLayout::kRgb, .size = {kWidth, kHeight}, .bytes = pixels},
                       80, pixels.size(), jpeg));
  for (const rack::u16 mode :
       {camera_mode::kMono8, camera_mode::kRgb24, camera_mode::kYuv422, camera_mode::kJpeg})
    measure("MJPG to " + std::string(name_of_mode(mode)), 40,
            [&] { check(maker.make({.format = video::kMjpeg}, jpeg, mode, picture)); });
  check(maker.make({.format = video::kMjpeg}, jpeg, camera_mode::kRgb24, picture));
  measure("brightness of rgb24", 400, [&] { (void)brightness_of(picture, 1); });
}

void measure_stereo() {
  // Spots of three pixels; the lower half is nearer.
  std::vector<std::byte> pair(std::size_t{2} * kWidth * kHeight);
  const auto spots = [](std::uint32_t x, std::uint32_t y) {
    std::uint32_t hash = x / 3 * 374761393U + y / 3 * 668265263U;
    hash = (hash ^ hash >> 13) * 1274126177;
    return static_cast<std::byte>(hash >> 16 & 0xFF);
  };
  for (std::uint32_t y = 0; y < kHeight; ++y)
    for (std::uint32_t x = 0; x < kWidth; ++x) {
      const std::size_t at = std::size_t{y} * 2 * kWidth + x;
      pair[at] = spots(x, y);
      pair[at + kWidth] = spots(x + (y < kHeight / 2 ? 6 : 20), y);
    }
  for (const auto& [name, method] : {std::pair{"stereo, block", StereoMethod::kBlock},
                                     std::pair{"stereo, semiglobal", StereoMethod::kSemiGlobal}}) {
    Stereo stereo({.method = method});
    measure(name, 2, [&] {
      if (!stereo.match(pair, kWidth, kHeight)) std::puts("  failed");
    });
  }
}

// The corridor of the indoor sample: walls, floor and ceiling, three people, a lens and noise.
void measure_camera_of_world() {
  namespace world = rack::world;
  world::WorldDescription corridor;
  corridor.ceiling = 2500;
  corridor.people.height = 1700;
  for (const double side : {-1500.0, 1500.0})
    for (double at = -1500; at < 8500; at += 2500)
      corridor.walls.push_back({.from = {at, side}, .to = {at + 2500, side}});
  corridor.walls.push_back({.from = {8500, -1500}, .to = {8500, 1500}});
  corridor.obstacles = {{.at = {7000, 1000}, .height = 500}};
  corridor.markers = {{.id = 1, .at = {8500, 0}, .rho = rack::kPi, .height = 1000, .size = 250}};
  corridor.robots.emplace_back();
  world::SensorDescription camera{.kind = world::SensorKind::kCamera};
  camera.mount.z = -600;
  camera.noise.pixel = 2;
  camera.camera.k1 = -0.08;
  camera.camera.k2 = 0.01;
  corridor.robots[0].sensors = {camera};
  world::View view{.from = {0, 0, -600}, .turn = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  view.people = {{.at = {2500, 400}}, {.at = {4000, -500}, .rho = 2}, {.at = {6000, 0}}};
  for (const auto& [name, width, height] : {std::tuple{"World's camera, 320 x 240", 320, 240},
                                            std::tuple{"World's camera, 640 x 480", 640, 480}}) {
    corridor.robots[0].sensors[0].camera.width = width;
    corridor.robots[0].sensors[0].camera.height = height;
    corridor.robots[0].sensors[0].camera.focal = width * 0.866;
    const auto renderer = world::CameraRenderer::make(corridor, {0, 0});
    if (!renderer) return std::puts("  failed"), void();
    measure(name, 10, [&] {
      if (!(*renderer)->render(view)) std::puts("  failed");
    });
  }
}

}  // namespace
}  // namespace tims::bench

int main(int argc, char** argv) {
  rack::pictures::use_one_thread();
  if (argc == 3) return tims::bench::write_pictures(argv[1], std::stoi(argv[2])) ? 0 : 1;
  tims::bench::measure_conversions();
  tims::bench::measure_stereo();
  tims::bench::measure_camera_of_world();
}

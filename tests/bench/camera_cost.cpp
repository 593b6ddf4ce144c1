#include "tests/bench/camera_cost.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>
#include <vector>

#include "libtims/os/clock.h"
#include "rack/proxies/camera.h"
#include "tests/bench/launch.h"
#include "tests/bench/metrics.h"
#include "tests/bench/usage.h"
#include "tims/session.h"

namespace tims::bench {
namespace {

constexpr std::uint32_t kCameraCostWidth = 640;
constexpr int kPictures = 30;         // repeated from the first
constexpr double kRate = 30;          // per second
constexpr double kRateOfFolder = 20;  // default of play: for folders

std::string name_of(const std::string& folder, int index) {
  const std::string number = std::to_string(index);
  return folder + "/" + std::string(4 - number.size(), '0') + number + ".jpg";
}

// The program that makes the pictures is apart, because OpenCV makes programs slow to start.
std::filesystem::path picture_maker() {
  return std::filesystem::read_symlink("/proc/self/exe").replace_filename("tims-bench-pictures");
}

Result<std::string> make_pictures(const std::string& scratch) {
  std::string folder = scratch + "/pictures";
  auto maker = launch({picture_maker(), folder, std::to_string(kPictures)}, false);
  if (!maker) return maker.error();
  const auto ended = maker->wait();
  if (!ended) return ended.error();
  if (!std::filesystem::exists(name_of(folder, kPictures - 1)))
    return Error(Errc::kSystem, "no pictures: " + maker->output());
  return folder;
}

void print_cost(const Usage& spent, Duration passed, std::size_t bytes, std::uint64_t pictures) {
  constexpr double kPercent = 100;
  const double seconds = std::chrono::duration<double>(passed).count();
  print_metric("cpu_percent", kPercent * spent.cpu_s / seconds);
  print_metric("pictures_per_s", static_cast<double>(pictures) / seconds);
  print_metric("picture_kb", static_cast<double>(bytes) / static_cast<double>(pictures) * 1e-3);
}

bool listen(const Plan& plan, pid_t driver) {
  auto session = Session::connect({.name = "listener", .router = plan.socket});
  if (!session) return complain(session.error());
  const auto address = [](std::uint32_t local) {
    return Address::of({.class_id = class_id::kTest, .instance = 0, .local = local});
  };
  auto work = session->open({.address = address(0), .slots = 4, .body_max = 256});
  auto data = session->open(
      {.address = address(1), .slots = 4, .body_max = rack::body_max<rack::CameraData>()});
  if (!work || !data) return false;
  rack::CameraProxy camera(*work, Address::of({.class_id = class_id::kCamera}));
  const Time give_up = os::now() + kStartLimit;  // its program may still be starting
  while (!camera.on() && os::now() < give_up) std::this_thread::yield();
  if (auto wanted = camera.get_cont_data(0, data->address()); !wanted)
    return complain(wanted.error());
  rack::CameraData picture;
  std::size_t bytes = 0;
  Usage before;
  Time began{};
  for (std::uint64_t i = 0; i <= plan.count; ++i) {
    const auto message = data->peek_for(kStartLimit);
    if (!message) return complain(message.error());
    if (!camera.decode_stream(*message, picture) || picture.mode != rack::camera_mode::kJpeg ||
        picture.width != kCameraCostWidth)
      return complain(Error(Errc::kMalformed, "a picture differs from the camera's"));
    if (i == 0) {  // earlier time is its start
      before = usage_of(driver);
      began = os::now();
    } else {
      bytes += picture.image.size();
    }
  }
  print_cost(usage_of(driver) - before, os::now() - began, bytes, plan.count);
  return true;
}

}  // namespace

bool has_pictures() { return std::filesystem::exists(picture_maker()); }

bool measure_camera(const Plan& plan) {
  const auto folder = make_pictures(plan.folder);
  if (!folder) return complain(folder.error());
  auto driver =
      launch({std::filesystem::read_symlink("/proc/self/exe").replace_filename("CameraV4l"),
              "--router=" + plan.socket,
              "--device=play:" + *folder + "?loop=1&speed=" + std::to_string(kRate / kRateOfFolder),
              "--mode=jpeg", "--fps=30"},
             false);
  if (!driver) return complain(driver.error());
  if (listen(plan, driver->pid())) return true;
  std::fputs(driver->output().c_str(), stderr);
  return false;
}

bool measure_bare_pictures(const Plan& plan) {
  const auto folder = make_pictures(plan.folder);
  if (!folder) return complain(folder.error());
  std::vector<char> picture;
  std::size_t bytes = 0;
  const Usage before = own_usage();
  const Time began = os::now();
  for (std::uint64_t i = 0; i < plan.count; ++i) {
    const std::chrono::duration<double> due(static_cast<double>(i) / kRate);
    std::this_thread::sleep_until(std::chrono::steady_clock::time_point(
        (began + std::chrono::duration_cast<Duration>(due)).time_since_epoch()));
    std::ifstream file(name_of(*folder, static_cast<int>(i % kPictures)),
                       std::ios::binary | std::ios::ate);
    picture.resize(static_cast<std::size_t>(file.tellg()));
    file.seekg(0);
    file.read(picture.data(), static_cast<std::streamsize>(picture.size()));
    bytes += picture.size();
  }
  print_cost(own_usage() - before, os::now() - began, bytes, plan.count);
  return true;
}

}  // namespace tims::bench

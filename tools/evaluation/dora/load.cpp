#include "tools/evaluation/dora/load.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>

#include "components/geometry/random.h"
#include "components/pictures/jpeg.h"
#include "os/clock.h"
#include "rack/proxies/camera.h"
#include "rack/proxies/datalog.h"
#include "tools/cli/failure.h"

namespace rack::dora {
namespace {

using namespace std::chrono_literals;
using timsctl::Exit;
using timsctl::Failure;

// deploy/robots/dora-laser.toml plays the pictures, dora-base.toml stores the recording.
constexpr const char* kPictures = "/tmp/rack-dora-1-pictures";
constexpr const char* kRecord = "/tmp/rack-dora-1-record";
constexpr const char* kCamera = "Camera(1/0)";
constexpr const char* kRecorder = "Datalog(1/0)";
constexpr int kPicturesInFolder = 20;  // one second of the camera
// Together with the recording this fills the link of 20 Mbit/s.
constexpr std::chrono::milliseconds kPeriod = 500ms;
constexpr std::size_t kPictureMax = 4U << 20;
// The classes that are recorded at the base; scans alone take 3 Mbit/s.
constexpr std::array<std::uint32_t, 5> kRecordedModules = {
    tims::class_id::kScan2d, tims::class_id::kPosition, tims::class_id::kOdometry,
    tims::class_id::kChassis, tims::class_id::kPilot};

void need(const Result<void>& done, const std::string& what) {
  if (!done) throw Failure(Exit::kNo, "no_load", what + ": " + done.error().message());
}

// Noise cannot be compressed: the picture keeps its size on all hops.
std::vector<std::byte> picture() {
  constexpr pictures::PictureSize kSize{.width = 1024, .height = 672};
  Random random(1);
  std::vector<std::byte> pixels(std::size_t{kSize.width} * kSize.height);
  for (std::byte& pixel : pixels) pixel = static_cast<std::byte>(random.uniform() * 256);
  pictures::Jpeg encoder;
  std::vector<std::byte> jpeg;
  need(encoder.encode({.layout = pictures::PixelLayout::kGrey, .size = kSize, .bytes = pixels}, 100,
                      kPictureMax, jpeg),
       "a picture");
  return jpeg;
}

void write_pictures() {
  const std::filesystem::path folder = kPictures;
  std::filesystem::create_directories(folder);
  const auto jpeg = picture();
  const auto first = folder / "00.jpg";
  std::ofstream file(first, std::ios::binary);
  file.write(reinterpret_cast<const char*>(jpeg.data()), std::ssize(jpeg));
  if (!file.flush())
    throw Failure(Exit::kDenied, "no_pictures", first.string() + ": cannot write the file");
  for (int i = 10; i < 10 + kPicturesInFolder - 1; ++i) {
    std::error_code there;
    std::filesystem::create_hard_link(first, folder / (std::to_string(i) + ".jpg"), there);
  }
}

}  // namespace

Load::Load(Subscriptions& base)
    : base_(base), stream_(base.open({.slots = 4, .body_max = kPictureMax})) {
  try {
    write_pictures();
    std::filesystem::create_directories(kRecord);
    begin();
  } catch (const std::filesystem::filesystem_error& error) {
    remove_files();
    throw Failure(Exit::kDenied, "no_load", error.what());
  } catch (...) {
    remove_files();
    throw;
  }
}

Load::~Load() {
  end();
  remove_files();
}

void Load::begin() {
  CameraProxy camera(base_.work(), address_of(kCamera), {.on = 5s});
  need(camera.on(), kCamera);
  DatalogProxy recorder(base_.work(), address_of(kRecorder), {.on = 10s});
  auto log = recorder.get_log_status(10s);
  if (!log)
    throw Failure(Exit::kNo, "no_load", std::string(kRecorder) + ": " + log.error().message());
  for (DatalogLogInfo& info : log->logInfo) {
    const auto module = info.moduleMbx.fields(base_.work().address_widths()).class_id;
    info.logEnable = std::ranges::find(kRecordedModules, module) != kRecordedModules.end() ? 1 : 0;
  }
  need(recorder.set_log(*log), kRecorder);
  need(recorder.on(), kRecorder);
  const auto asked = camera.get_cont_data(kPeriod.count(), stream_.address());
  if (!asked)
    throw Failure(Exit::kNo, "no_load", std::string(kCamera) + ": " + asked.error().message());
  began_ = tims::os::now();
}

void Load::keep() {
  for (;;) {
    const auto picture = stream_.try_peek();
    if (!picture) return;
    if (picture->header().type != tims::type::kData) continue;
    ++pictures_;
    picture_bytes_ = picture->header().length;
  }
}

double Load::share() const {
  const double taken = std::chrono::duration<double>(length_) / kPeriod;
  return taken > 0 ? static_cast<double>(pictures_) / taken : 0;
}

void Load::end() {
  if (began_ == Time{}) return;
  length_ = tims::os::now() - began_;
  began_ = {};
  Proxy camera(base_.work(), address_of(kCamera));
  (void)camera.stop_cont_data(stream_.address());
  (void)camera.off();
  DatalogProxy recorder(base_.work(), address_of(kRecorder));
  if (const auto log = recorder.get_log_status())
    for (const DatalogLogInfo& info : log->logInfo) recorded_ += info.setsLogged;
  (void)recorder.off();
}

void Load::remove_files() const {
  for (const char* const folder : {kPictures, kRecord}) {
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
  }
}

}  // namespace rack::dora

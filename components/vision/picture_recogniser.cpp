#include "components/vision/picture_recogniser.h"

#include <utility>

#include "components/pictures/opencv_call.h"

namespace rack::vision {

namespace {

constexpr int kMissesMax = 20;  // pictures in a row without a position of their time
constexpr std::chrono::milliseconds kPositionLate{300};  // it is waited for

}  // namespace

PictureRecogniser::PictureRecogniser(const ModuleInfo& info) : DataModule(info, {.history = 20}) {
  reserve_all(picture_);
  pictures::use_one_thread();
}

Result<void> PictureRecogniser::module_on() {
  misses_ = 0;
  geometry_.reset();
  if (auto on = position_.turn_on(); !on) return on;
  const auto granted = camera_.start(std::chrono::milliseconds(integer("period")));
  if (!granted) return granted.error();
  const auto lens = camera_->get_parameter();
  if (!lens) return lens.error();
  lens_ = *lens;
  set_period(*granted);
  return DataModule::module_on();
}

void PictureRecogniser::module_off() { camera_.stop(); }

Result<void> PictureRecogniser::module_loop() {
  if (auto come = camera_.next(picture_, patience_with(period())); !come) return come;
  // Of those that arrived meanwhile only the newest is of interest.
  for (auto more = camera_.another(picture_); more; more = camera_.another(picture_))
    if (!*more) break;
  const TimeStamp time = picture_.recordingTime - std::chrono::milliseconds(integer("cameraLag"));
  std::optional<PositionData> at;
  if (position_) {
    PositionData known;
    if (auto come = position_then_.get(*position_, known, time, kPositionLate); !come) {
      // The position may be late or may have just started.
      if (++misses_ > kMissesMax) return come;
      return {};
    }
    at = known;
  }
  misses_ = 0;
  const auto grey = grey_.take(picture_);
  if (!grey) return grey.error();
  if (auto adapted = adapt_to(*grey); !adapted) return adapted;
  ObjRecogData& data = get_local_buffer();
  data = {.recordingTime = time};
  if (at) {
    data.refPos = at->pos;
    data.varRefPos = at->var;
  }
  if (auto done = recognise(*grey, *geometry_, at, data); !done) return done;
  return put_local_buffer();
}

Result<void> PictureRecogniser::adapt_to(const GreyView& picture) {
  if (geometry_ && picture.width == width_ && picture.height == height_) return {};
  width_ = picture.width;
  height_ = picture.height;
  const auto geometry = CameraGeometry::make(lens_, width_, height_, mounting());
  if (!geometry) return geometry.error();
  geometry_ = *geometry;
  return {};
}

Pose PictureRecogniser::mounting() const {
  const auto length = [this](const char* name) { return static_cast<double>(integer(name)); };
  const auto angle = [this](const char* name) { return radians(static_cast<double>(real(name))); };
  return {.x = length("cameraX"),
          .y = length("cameraY"),
          .z = -length("cameraHeight"),
          .phi = angle("cameraPhi"),
          .psi = angle("cameraPsi"),
          .rho = angle("cameraRho")};
}

}  // namespace rack::vision

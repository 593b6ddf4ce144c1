// ObjRecogMarkers: AprilTags in the pictures of a camera, as objects, and where the robot is by
// those of a map.
#include <filesystem>
#include <set>

#include "components/vision/fix_gate.h"
#include "components/vision/marker_finder.h"
#include "components/vision/picture_recogniser.h"
#include "components/vision/robot_fix.h"
#include "os/file.h"

namespace rack::vision {
namespace {

constexpr auto kParameters =
    joined(kPictureParameters,
           std::array<ParameterInfo, 5>{{
               host_file({"markerFile", "",
                          "map of the markers (TOML); empty: none, the position is not updated"}),
               one_of("tag36h11, tag25h9, tag16h5",
                      {"family", "tag36h11", "family of markers that are not in the map"}),
               {"markerSize", 160,
                "size of markers that are not in the map: side of the black square [mm]", 10, 5000},
               {"maxRange", 8000, "markers beyond it are not used for the position [mm]", 100, 1e6},
               {"updatePeriod", 500, "between updates of the position, at least [ms]", 0, 3600000},
           }});

constexpr ModuleInfo kInfo{
    .program = "ObjRecogMarkers",
    .purpose =
        "Recognises AprilTags in the pictures of a camera, and updates the position by them.",
    .class_id = tims::class_id::kObjRecog,
    .parameters = kParameters,
};

constexpr std::size_t kFileMax = 1 << 20;

class ObjRecogMarkers : public PictureRecogniser {
 public:
  ObjRecogMarkers() : PictureRecogniser(kInfo) {}

 private:
  Result<void> module_on() override {
    if (auto good = take_map(); !good) return good;
    const auto family = family_of(text("family"));
    if (!family)
      return refused("family must be tag36h11, tag25h9 or tag16h5, not " + text("family"));
    std::set<Family> families{*family};
    for (const Marker& marker : map_) families.insert(marker.family);
    finder_.emplace(families);
    gate_ = {};
    updated_.reset();
    return PictureRecogniser::module_on();
  }

  Result<void> take_map() {
    map_.clear();
    const std::string path = text("markerFile");
    if (path.empty()) return {};
    auto bytes = tims::os::read_file(path, kFileMax);
    if (!bytes) return bytes.error();
    MarkerFile file = read_marker_map({path, std::move(*bytes)});
    if (!file.problems.empty()) return refused(file.problems.front().to_string());
    if (file.markers.empty()) return refused(path + ": no markers");
    map_ = std::move(file.markers);
    log().info("{} has {} markers", path, map_.size());
    return {};
  }

  Result<void> recognise(const GreyView& picture, const CameraGeometry& camera,
                         const std::optional<PositionData>& at, ObjRecogData& objects) override {
    const auto found = finder_->find(picture);
    if (!found) return found.error();
    landmarks_.clear();
    for (const Sighting& seen : *found) {
      const Marker* const known = in_map(seen);
      const double size = known != nullptr ? known->size : integer("markerSize");
      const auto poses = poses_of(seen, size, camera);
      if (!poses) continue;  // its corners are no square: a mistake
      add(seen, poses->front(), size, camera.lens(), objects);
      const scan3d::Place& place = poses->front().at;
      if (known != nullptr && std::hypot(place.x, place.y) <= integer("maxRange"))
        landmarks_.push_back({*known, seen.corners, *poses});
    }
    return at ? update_position(*at, camera) : Result<void>();
  }

  [[nodiscard]] const Marker* in_map(const Sighting& seen) const {
    const auto found = std::ranges::find_if(map_, [&](const Marker& m) { return seen.shows(m); });
    return found == map_.end() ? nullptr : &*found;
  }

  static void add(const Sighting& seen, const MarkerPose& pose, double size, const Lens& lens,
                  ObjRecogData& objects) {
    if (objects.objects.size() == decltype(objects.objects)::kMax) return;
    // Half a pixel of its size changes the distance by this.
    const double range = std::hypot(pose.at.x, pose.at.y);
    const i32 deviation = whole_millimetres(10 + 0.5 * range * range / (lens.fx * size));
    ObjRecogObject object{.objectId = seen.id, .prob = 1};
    object.pos = Pose{.x = pose.at.x, .y = pose.at.y, .z = pose.at.z, .rho = pose.rho}.position();
    object.varPos.x = object.varPos.y = object.varPos.z = deviation;
    object.dim.y = object.dim.z = whole_millimetres(size);
    const auto [left, right] = std::ranges::minmax(seen.corners, {}, &ImagePoint::column);
    const auto [top, bottom] = std::ranges::minmax(seen.corners, {}, &ImagePoint::row);
    object.imageArea = {.x = static_cast<i32>(left.column),
                        .y = static_cast<i32>(top.row),
                        .width = static_cast<i32>(right.column - left.column),
                        .height = static_cast<i32>(bottom.row - top.row)};
    objects.objects.push_back(object);
  }

  Result<void> update_position(const PositionData& at, const CameraGeometry& camera) {
    if (landmarks_.empty()) return {};
    const Pose believed = Pose::of(at.pos);
    const double deviation = std::max(at.var.x.raw(), at.var.y.raw());
    const auto fix =
        gate_.take(at.recordingTime, fixes_of(landmarks_, camera), believed, deviation);
    if (!fix) return {};
    const double away = std::hypot(fix->pose.x - believed.x, fix->pose.y - believed.y);
    const bool is_elsewhere = away > 1000;
    if (!is_elsewhere && updated_ &&
        at.recordingTime - *updated_ < std::chrono::milliseconds(integer("updatePeriod")))
      return {};
    updated_ = at.recordingTime;
    if (is_elsewhere)
      log().print("Found by markers at x {:.2f} m, y {:.2f} m, {:.2f} m from the position",
                  fix->pose.x / 1000, fix->pose.y / 1000, away / 1000);
    PositionData known{.recordingTime = at.recordingTime};
    known.pos = fix->pose.position();
    known.pos.z = at.pos.z;
    known.var.x = known.var.y = whole_millimetres(fix->deviation);
    known.var.rho = static_cast<float>(fix->deviation_rho);
    return position()->update(known);
  }

  std::vector<Marker> map_;
  std::optional<MarkerFinder> finder_;
  std::vector<Landmark> landmarks_;
  FixGate gate_;
  std::optional<TimeStamp> updated_;
};

}  // namespace
}  // namespace rack::vision

int main(int argc, char** argv) {
  rack::vision::ObjRecogMarkers recognition;
  return recognition.run(argc, argv);
}

// ObjRecogPeople: people in the pictures of a camera, as objects.
#include <algorithm>
#include <cmath>

#include "components/vision/people_finder.h"
#include "components/vision/person_place.h"
#include "components/vision/person_tracks.h"
#include "components/vision/picture_recogniser.h"

namespace rack::vision {
namespace {

constexpr auto kPeopleParameters =
    joined(kPictureParameters,
           std::array<ParameterInfo, 4>{{
               {"personHeight", 1750, "of the people, on average [mm]", 500, 3000},
               {"minScore", 0.5F,
                "of the detector: higher finds fewer people and fewer other things", 0, 10},
               {"maxRange", 10000, "people beyond it are not searched [mm]", 1000, 100000},
               {"maxWidth", 640,
                "of the searched picture [pixels]: larger ones are reduced, which is faster and "
                "finds fewer distant people",
                64, 1920},
           }});

constexpr ModuleInfo kPeopleInfo{
    .program = "ObjRecogPeople",
    .purpose =
        "Recognises people in the pictures of a camera and estimates their places and speeds.",
    .class_id = tims::class_id::kObjRecog,
    .parameters = kPeopleParameters,
};

constexpr double kPersonWidth = 500;        // mm
constexpr double kHeightDeviation = 0.057;  // part of the height of adults
constexpr double kUnknownSpeed = 2000;      // mm/s: people walk

// Turns a vector from the robot's frame to that of the position, or a covariance.
Eigen::Matrix2d turn_of(double rho) {
  Eigen::Matrix2d turn;
  turn << std::cos(rho), -std::sin(rho), std::sin(rho), std::cos(rho);
  return turn;
}

i32 deviation_of(double variance) { return whole_millimetres(std::sqrt(std::max(variance, 0.0))); }
i32 speed_of(double speed) { return static_cast<i32>(std::lround(std::clamp(speed, -1e6, 1e6))); }

// The person in the window, as far as it is in the picture.
ImageRect area_of(const PersonBox& box, const GreyView& picture) {
  const auto within = [](double value, int most) {
    return static_cast<i32>(std::clamp(value, 0.0, static_cast<double>(most)));
  };
  const i32 left = within(box.middle() - box.width / 4, picture.width);
  const i32 right = within(box.middle() + box.width / 4, picture.width);
  const i32 top = within(box.head(), picture.height);
  const i32 bottom = within(box.feet(), picture.height);
  return {.x = left, .y = top, .width = right - left, .height = bottom - top};
}

class ObjRecogPeople : public PictureRecogniser {
 public:
  ObjRecogPeople() : PictureRecogniser(kPeopleInfo) {}

 private:
  Result<void> module_on() override {
    tracks_.forget();
    previous_.reset();
    return PictureRecogniser::module_on();
  }

  Result<void> recognise(const GreyView& picture, const CameraGeometry& camera,
                         const std::optional<PositionData>& at, ObjRecogData& objects) override {
    const double height = integer("personHeight");
    const PersonMeasures measures{.height = height,
                                  .deviation = kHeightDeviation * height,
                                  .range_max = static_cast<double>(integer("maxRange"))};
    const auto place = [&](const PersonBox& box) {
      return place_of(box, camera, picture.height, measures);
    };
    const auto found = finder_.find(
        picture, {.smallest = apparent_height(height, measures.range_max, camera),
                  .side_max = integer("maxWidth"),
                  .score_min = real("minScore"),
                  .is_possible = [&](const PersonBox& box) { return place(box).has_value(); }});
    if (!found) return found.error();
    sightings_.clear();
    seen_.clear();
    const Ground ground{at ? Pose::of(at->pos) : Pose{}, at.has_value()};
    for (const PersonBox& box : *found)
      if (const auto at_box = place(box)) {
        sightings_.push_back(ground.sighting(*at_box, probability_of(box.score)));
        seen_.push_back({area_of(box, picture), at_box->height});
      }
    const double time = seconds_at(objects.recordingTime);
    tracks_.take(sightings_, time);
    for (const PersonTrack& track : tracks_.tracks())
      if (track.is_confirmed() && objects.objects.size() < decltype(objects.objects)::kMax)
        objects.objects.push_back(describe(track, time, ground));
    return {};
  }

  // Since the first picture. Time stamps begin again at 0 after 50 days.
  double seconds_at(TimeStamp time) {
    if (previous_) seconds_ += std::chrono::duration<double>(time - *previous_).count();
    previous_ = time;
    return seconds_;
  }

  // The frame in which people are followed: that of the position, or of the robot without one.
  struct Ground {
    Pose robot;
    bool is_known;

    [[nodiscard]] PersonSighting sighting(const PersonPlace& place, double probability) const {
      const Eigen::Matrix2d line = turn_of(robot.rho + place.direction);
      const Eigen::DiagonalMatrix<double, 2> variances(
          place.deviation_range * place.deviation_range,
          place.deviation_across * place.deviation_across);
      return {.at = Eigen::Vector2d(robot.x, robot.y) +
                    turn_of(robot.rho) * Eigen::Vector2d(place.x, place.y),
              .covariance = line * variances * line.transpose(),
              .probability = probability};
    }
  };
  struct Seen {
    ImageRect area;
    double height;
  };

  [[nodiscard]] ObjRecogObject describe(const PersonTrack& track, double time,
                                        const Ground& ground) const {
    const Eigen::Matrix2d to_robot = turn_of(-ground.robot.rho);
    const Eigen::Vector2d at =
        to_robot * (track.at() - Eigen::Vector2d(ground.robot.x, ground.robot.y));
    const Eigen::Matrix2d variance = to_robot * track.covariance() * to_robot.transpose();
    double height = integer("personHeight");
    ObjRecogObject object{.objectId = track.id(),
                          .type = object_type::kPedestrian,
                          .prob = static_cast<f32>(track.probability(time))};
    if (const auto seen = track.sighting()) {
      object.imageArea = seen_[*seen].area;
      height = seen_[*seen].height;
    }
    object.pos = Pose{.x = at.x(), .y = at.y(), .z = -height / 2}.position();
    object.varPos.x = deviation_of(variance(0, 0));
    object.varPos.y = deviation_of(variance(1, 1));
    object.varPos.z = whole_millimetres(kHeightDeviation * height / 2);
    object.dim.x = object.dim.y = whole_millimetres(kPersonWidth);
    object.dim.z = whole_millimetres(height);
    object.varVel.x = object.varVel.y = speed_of(kUnknownSpeed);
    if (ground.is_known) {
      const Eigen::Vector2d velocity = to_robot * track.velocity();
      const Eigen::Matrix2d doubt = to_robot * track.velocity_covariance() * to_robot.transpose();
      object.vel.x = speed_of(velocity.x());
      object.vel.y = speed_of(velocity.y());
      object.varVel.x = deviation_of(doubt(0, 0));
      object.varVel.y = deviation_of(doubt(1, 1));
    }
    return object;
  }

  PeopleFinder finder_;
  PersonTracks tracks_;
  std::optional<TimeStamp> previous_;
  double seconds_ = 0;
  std::vector<PersonSighting> sightings_;  // of the newest picture
  std::vector<Seen> seen_;                 // one for each of them
};

}  // namespace
}  // namespace rack::vision

int main(int argc, char** argv) {
  rack::vision::ObjRecogPeople recognition;
  return recognition.run(argc, argv);
}

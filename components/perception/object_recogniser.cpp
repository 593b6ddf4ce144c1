#include "components/perception/object_recogniser.h"

#include <algorithm>
#include <cmath>

#include "components/perception/pose_search.h"

namespace rack::perception {
namespace {

constexpr std::size_t kBeamsOfSearch = 180;
constexpr double kPauseMost = 2;    // s between two scans
constexpr double kJump = 1000;      // mm, of the position
constexpr double kFastest = 15000;  // mm/s
constexpr double kJumpTurn = radians(30);
constexpr double kFastestTurn = radians(360);  // 1/s
constexpr double kSlips = 0.1;  // share of a scan that has moved although it is in the map
constexpr double kSlipsWithoutMap = 0.3;   // share of a scan that has moved
constexpr double kMostOfUnknown = 100000;  // mm: maximum deviation in a message

f32 real(double value) { return static_cast<f32>(value); }

i32 speed_of(double value) { return static_cast<i32>(std::lround(std::clamp(value, -1e6, 1e6))); }

}  // namespace

ObjectRecogniser::ObjectRecogniser(const RecogniserSettings& settings,
                                   const localisation::LikelihoodField* map)
    : settings_(settings), map_(map), tracker_({.only_moved = map == nullptr}) {
  order_.reserve(ObjectTracker::kTracksMax);
  beams_.reserve(kBeamsOfSearch + 1);
}

void ObjectRecogniser::forget() {
  memory_.forget();
  tracker_.forget();
  started_ = false;
}

bool ObjectRecogniser::jumped(double seconds, const Pose& robot) const {
  const Pose step = robot - reported_;
  return seconds > kPauseMost || std::hypot(step.x, step.y) > kJump + kFastest * seconds ||
         std::abs(signed_angle(step.rho)) > kJumpTurn + kFastestTurn * seconds;
}

bool ObjectRecogniser::take(const Scan2dData& scan, const PositionData& robot) {
  const Pose pose = Pose::of(robot.pos);
  if (!std::isfinite(pose.x + pose.y + pose.rho)) return false;
  if (started_) {
    const double passed = std::chrono::duration<double>(scan.recordingTime - time_).count();
    if (passed == 0) return false;
    // Time has gone backwards: a recording that restarts, or a clock that was set.
    if (passed < 0 || jumped(passed, pose)) forget();
    seconds_ += std::max(passed, 0.0);
  }
  view_.take(scan, settings_.scanner, settings_.range_max);
  if (map_ != nullptr)
    robot_ = lay_on_map(pose);
  else
    robot_ = started_ ? memory_.lay_on(view_, robot_ + (pose - reported_)) : pose;
  view_.place(robot_);
  reported_ = pose;
  started_ = true;
  time_ = scan.recordingTime;
  position_ = robot;
  memory_.look(view_, seconds_);
  explain();
  const MapPoint scanner{view_.scanner().x, view_.scanner().y};
  tracker_.take(finder_.find(view_, settings_.size_max), scanner, memory_.now(), seconds_);
  return true;
}

Pose ObjectRecogniser::lay_on_map(const Pose& robot) {
  beams_.clear();
  const std::size_t step = view_.sights().size() / kBeamsOfSearch + 1;
  for (std::size_t i = 0; i < view_.sights().size(); i += step) {
    const Sight& sight = view_.sights()[i];
    if (sight.hit) beams_.add({sight.local_x, sight.local_y});
  }
  return nearest_fit(robot, {}, [&](const Pose& pose) { return 1 - map_->fit(pose, beams_); });
}

void ObjectRecogniser::explain() {
  std::size_t hits = 0;
  std::size_t contradictions = 0;
  for (Sight& sight : view_.sights()) {
    sight.explained = map_ != nullptr && map_->distance(sight.x, sight.y) <= settings_.tolerance;
    hits += sight.hit ? 1 : 0;
    contradictions += sight.moved && (sight.explained || map_ == nullptr) ? 1 : 0;
  }
  // Obstacles of the map do not move, nor does a large part of a room: if they seem to, the
  // position is wrong.
  const double most = map_ != nullptr ? kSlips : kSlipsWithoutMap;
  if (static_cast<double>(contradictions) > most * static_cast<double>(hits))
    for (Sight& sight : view_.sights()) sight.moved = false;
}

void ObjectRecogniser::to_message(ObjRecogData& data) {
  data.recordingTime = time_;
  data.refPos = position_.pos;
  data.varRefPos = position_.var;
  data.objects.clear();
  order_.clear();
  for (const Track& track : tracker_.tracks())
    if (track.published()) order_.push_back(&track);
  const auto away = [&](const Track& track) {
    return std::hypot(track.at().x - robot_.x, track.at().y - robot_.y);
  };
  std::ranges::sort(order_, [&](const Track* a, const Track* b) {
    if (a->moving() != b->moving()) return a->moving();
    return away(*a) < away(*b);
  });
  const std::size_t most =
      std::min(settings_.objects_max, static_cast<std::size_t>(decltype(data.objects)::kMax));
  for (std::size_t i = 0; i < std::min(order_.size(), most); ++i)
    data.objects.push_back(describe(*order_[i]));
}

ObjRecogObject ObjectRecogniser::describe(const Track& track) const {
  const double c = std::cos(robot_.rho);
  const double s = std::sin(robot_.rho);
  const double dx = track.at().x - robot_.x;
  const double dy = track.at().y - robot_.y;
  const MapPoint v = track.moving() ? track.velocity() : MapPoint{};
  const auto deviation = static_cast<i32>(std::lround(std::min(track.deviation(), kMostOfUnknown)));
  const auto deviation_v = speed_of(track.speed_deviation());
  ObjRecogObject object;
  object.objectId = track.id();
  object.type = static_cast<i32>(track.kind());
  object.pos.x = whole_millimetres(dx * c + dy * s);
  object.pos.y = whole_millimetres(dy * c - dx * s);
  object.pos.rho = real(heading(track.heading() - robot_.rho));
  object.varPos.x = deviation;
  object.varPos.y = deviation;
  object.vel.x = speed_of(v.x * c + v.y * s);
  object.vel.y = speed_of(v.y * c - v.x * s);
  object.varVel.x = deviation_v;
  object.varVel.y = deviation_v;
  object.dim.x = whole_millimetres(track.length());
  object.dim.y = whole_millimetres(track.width());
  object.prob = real(track.probability());
  return object;
}

}  // namespace rack::perception

#include "tools/evaluation/track_eval/tracking.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "components/localisation/localiser.h"

namespace rack::track_eval {

using localisation::CarmenLog;
using localisation::LikelihoodField;
using localisation::Localiser;
using localisation::LogScan;
using perception::ObjectRecogniser;
using perception::Track;

namespace {

constexpr std::uint32_t kBeamsToBeSeen = 2;
constexpr double kBelongs = 500;  // mm
constexpr std::int32_t kNoTrack = 0;

// The object transformed to the true frame.
struct Reported {
  std::int32_t id;
  MapPoint at;
  MapPoint velocity;
  bool taken = false;
};

class People {
 public:
  People(Score& score, std::size_t count) : score_(score), last_(count, kNoTrack) {}

  void compare(const Hall& hall, const ObjRecogData& data) {
    transform(hall.robot(), data);
    const auto& people = hall.people();
    found_.assign(people.size(), nullptr);
    // A previous assignment is kept while the object is near enough.
    for (std::size_t i = 0; i < people.size(); ++i)
      for (Reported& reported : reported_)
        if (reported.id == last_[i] && distance(reported.at, people[i].at) < kBelongs)
          give(i, reported);
    for (std::size_t i = 0; i < people.size(); ++i)
      if (found_[i] == nullptr) give_nearest(i, people[i].at);
    for (std::size_t i = 0; i < people.size(); ++i) judge(i, people[i]);
    for (const Reported& reported : reported_) {
      if (reported.taken) continue;
      ++score_.wrong;
      if (std::hypot(reported.velocity.x, reported.velocity.y) > 0 &&
          ghosts_.insert(reported.id).second)
        ++score_.ghosts;
    }
  }

 private:
  void transform(const Pose& robot, const ObjRecogData& data) {
    reported_.clear();
    const double c = std::cos(robot.rho);
    const double s = std::sin(robot.rho);
    for (const ObjRecogObject& object : data.objects) {
      const double x = object.pos.x;
      const double y = object.pos.y;
      const double vx = object.vel.x;
      const double vy = object.vel.y;
      reported_.push_back({.id = object.objectId,
                           .at = {robot.x + x * c - y * s, robot.y + x * s + y * c},
                           .velocity = {vx * c - vy * s, vx * s + vy * c}});
    }
  }
  void give(std::size_t person, Reported& reported) {
    if (reported.taken || found_[person] != nullptr) return;
    reported.taken = true;
    found_[person] = &reported;
  }
  void give_nearest(std::size_t person, const MapPoint& at) {
    Reported* nearest = nullptr;
    for (Reported& reported : reported_)
      if (!reported.taken && distance(reported.at, at) < kBelongs &&
          (nearest == nullptr || distance(reported.at, at) < distance(nearest->at, at)))
        nearest = &reported;
    if (nearest != nullptr) give(person, *nearest);
  }
  void judge(std::size_t i, const Person& person) {
    const bool seen = person.beams >= kBeamsToBeSeen;
    const Reported* reported = found_[i];
    if (seen) ++score_.people;
    if (reported == nullptr) {
      if (seen) ++score_.missed;
      return;
    }
    if (seen) {
      if (last_[i] != kNoTrack && last_[i] != reported->id) ++score_.switches;
      score_.off.push_back(distance(reported->at, person.at));
      score_.speed.push_back(distance(reported->velocity, person.velocity));
    }
    last_[i] = reported->id;
  }

  Score& score_;
  std::vector<std::int32_t> last_;  // last object id of each person
  std::vector<Reported> reported_;
  std::vector<Reported*> found_;
  std::set<std::int32_t> ghosts_;
};

}  // namespace

double Score::mota() const {
  if (people == 0) return 0;
  return 1 - static_cast<double>(missed + wrong + switches) / static_cast<double>(people);
}

Score follow_people(const HallSettings& settings, double seconds, const LikelihoodField* map,
                    const Stopwatch& stopwatch) {
  Hall hall(settings);
  ObjectRecogniser recogniser({.range_max = settings.range_max}, map);
  Score score;
  People people(score, hall.people().size());
  Scan2dData scan;
  ObjRecogData data;
  std::size_t scans = 0;
  double us = 0;
  const auto steps = static_cast<std::size_t>(seconds / settings.period);
  for (std::size_t step = 0; step < steps; ++step) {
    hall.step();
    hall.scan(scan);
    const double before = stopwatch();
    if (!recogniser.take(scan, hall.position())) continue;
    recogniser.to_message(data);
    us += stopwatch() - before;
    ++scans;
    people.compare(hall, data);
  }
  score.minutes = seconds / 60;
  if (scans > 0) score.us_per_scan = us / static_cast<double>(scans);
  return score;
}

namespace {

constexpr double kSureShare = 0.95;  // as in mcl-eval
constexpr std::uint32_t kSureUpdates = 20;
constexpr double kOnMap = 300;  // mm

constexpr double kPause = 3;         // s
constexpr double kAtOnce = 0.25;     // fraction of the mean interval between scans
constexpr double kBunches = 0.1;     // fraction of such scans
constexpr std::size_t kAround = 12;  // neighbours on each side

// Scans from `begin` on, up to the next pause.
std::size_t end_of_run(const std::vector<LogScan>& scans, std::size_t begin) {
  std::size_t end = begin + 1;
  while (end < scans.size() && std::abs(scans[end].time - scans[end - 1].time) < kPause) ++end;
  return end;
}

bool has_bunches(const std::vector<LogScan>& scans) {
  double sum = 0;
  std::vector<double> steps;
  for (std::size_t i = 1; i < scans.size(); ++i) {
    const double step = scans[i].time - scans[i - 1].time;
    if (std::abs(step) >= kPause) continue;
    steps.push_back(step);
    sum += step;
  }
  const auto count = static_cast<double>(steps.size());
  const double least = kAtOnce * sum / std::max(count, 1.0);
  const auto at_once = std::ranges::count_if(steps, [&](double step) { return step < least; });
  return static_cast<double>(at_once) > kBunches * count;
}

class Drive {
 public:
  Drive(const CarmenLog& log, const DriveSettings& settings, const Stopwatch& stopwatch)
      : log_(log),
        settings_(settings),
        stopwatch_(stopwatch),
        times_(even_times(log.scans)),
        localiser_({}, settings.seed),
        recogniser_({.scanner = log.scans.front().laser, .range_max = log.range_max * 1000},
                    settings.subtract ? settings.map : nullptr) {}

  DriveScore run() {
    localiser_.start_anywhere();
    for (std::size_t i = 0; i < log_.scans.size(); ++i) step(log_.scans[i], times_[i]);
    if (score_.scans > 0) score_.us_per_scan = us_ / static_cast<double>(score_.scans);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      score_.movers[i].on_map /= std::max(1U, places_[i]);
      score_.movers[i].speed /= std::max(1U, places_[i]);
    }
    return std::move(score_);
  }

 private:
  void step(const LogScan& scan, double time) {
    const Pose odometry = log_.odometry_of(scan, settings_.lag);
    Pose robot = odometry;
    if (settings_.map != nullptr) {
      log_.beams(scan, beams_);
      if (localiser_.take(*settings_.map, odometry, beams_) && sure_ < kSureUpdates)
        sure_ = localiser_.estimate().share > kSureShare ? sure_ + 1 : 0;
      if (sure_ < kSureUpdates) return;
      robot = localiser_.pose();
    }
    make(scan, time);
    const double before = stopwatch_();
    if (!recogniser_.take(scan_, {.pos = robot.position()})) return;
    recogniser_.to_message(data_);
    us_ += stopwatch_() - before;
    ++score_.scans;
    if (last_ && time > *last_ && time < *last_ + 2) score_.minutes += (time - *last_) / 60;
    last_ = time;
    for (const Track& track : recogniser_.tracks()) {
      if (!track.published()) continue;
      ++score_.objects;
      if (track.moving()) note(track, time);
    }
  }

  void make(const LogScan& scan, double time) {
    const auto ms = static_cast<std::int64_t>(std::llround(time * 1000));
    scan_.recordingTime = static_cast<std::uint32_t>(ms);
    scan_.maxRange = whole_millimetres(log_.range_max * 1000);
    scan_.points.clear();
    for (std::size_t i = 0; i < scan.count; ++i) {
      const double range = 1000 * static_cast<double>(log_.ranges[scan.begin + i]);
      const double angle = scan.laser.rho + scan.first + scan.step * static_cast<double>(i);
      const bool nothing = range >= log_.range_max * 1000;
      if (scan_.points.size() == decltype(scan_.points)::kMax) break;
      scan_.points.push_back({.x = whole_millimetres(scan.laser.x + range * std::cos(angle)),
                              .y = whole_millimetres(scan.laser.y + range * std::sin(angle)),
                              .z = whole_millimetres(range),
                              .type = nothing ? scan_point::kInvalid | scan_point::kMaxRange : 0});
    }
  }

  void note(const Track& track, double time) {
    const double now = time - times_.front();
    auto mover = std::ranges::find(score_.movers, track.id(), &Mover::id);
    if (mover == score_.movers.end()) {
      score_.movers.push_back({.id = track.id(), .from = now, .first = track.at()});
      places_.push_back(0);
      mover = score_.movers.end() - 1;
    }
    ++places_[static_cast<std::size_t>(mover - score_.movers.begin())];
    mover->to = now;
    mover->last = track.at();
    mover->distance = std::max(mover->distance, distance(mover->first, track.at()));
    mover->speed += track.speed();
    mover->size = std::max(track.length(), track.width());
    mover->kind = track.kind();
    if (settings_.map != nullptr && settings_.map->distance(track.at().x, track.at().y) < kOnMap)
      mover->on_map += 1;
  }

  const CarmenLog& log_;
  const DriveSettings& settings_;
  const Stopwatch& stopwatch_;
  std::vector<double> times_;  // times of the scans
  Localiser localiser_;
  ObjectRecogniser recogniser_;
  DriveScore score_;
  std::vector<unsigned> places_;  // number of positions of each mover
  std::vector<localisation::BeamEnd> beams_;
  Scan2dData scan_;
  ObjRecogData data_;
  std::optional<double> last_;
  std::uint32_t sure_ = 0;
  double us_ = 0;
};

}  // namespace

std::vector<double> even_times(const std::vector<LogScan>& scans) {
  std::vector<double> times;
  times.reserve(scans.size());
  for (const LogScan& scan : scans) times.push_back(scan.time);
  if (!has_bunches(scans)) return times;
  for (std::size_t begin = 0, end = 0; begin < scans.size(); begin = end) {
    end = end_of_run(scans, begin);
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t half = std::min({kAround, i - begin, end - 1 - i});
      double sum = 0;
      for (std::size_t j = i - half; j <= i + half; ++j) sum += scans[j].time;
      times[i] = sum / static_cast<double>(2 * half + 1);
    }
  }
  return times;
}

DriveScore follow_drive(const CarmenLog& log, const DriveSettings& settings,
                        const Stopwatch& stopwatch) {
  return Drive(log, settings, stopwatch).run();
}

}  // namespace rack::track_eval

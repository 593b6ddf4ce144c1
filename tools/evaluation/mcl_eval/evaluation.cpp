#include "tools/evaluation/mcl_eval/evaluation.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace rack::mcl_eval {

using localisation::BeamEnd;
using localisation::CarmenLog;
using localisation::LikelihoodField;
using localisation::Localiser;
using localisation::LogScan;

namespace {

constexpr double kStartDistance = 500;  // mm
constexpr double kStartTurn = radians(15);
constexpr double kFoundDistance = 1000;  // mm
constexpr double kFoundTurn = radians(20);
constexpr double kSureShare = 0.95;  // fraction of the weight in one cluster
constexpr std::uint32_t kSureUpdates = 20;
constexpr double kCarried = 10000;  // mm

struct PoseError {
  double distance;
  double turn;
  [[nodiscard]] bool near() const { return distance <= kFoundDistance && turn <= kFoundTurn; }
};

PoseError error_of(const Pose& is, const Pose& should) {
  const Pose off = is - should;
  return {std::hypot(off.x, off.y), std::abs(signed_angle(off.rho))};
}

// The input of the robot, scan by scan, with all disturbances.
class Drive {
 public:
  Drive(const Trial& trial, const CarmenLog& log)
      : trial_(trial), log_(log), random_(trial.seed * 7919 + 17) {}

  // The odometry at the time of scan `i`. Must be called for consecutive scans.
  Pose odometry(std::size_t i) {
    const Pose now = log_.odometry_of(log_.scans[i], trial_.lag);
    if (raw_) {
      Pose step = now - *raw_;
      const double distance = std::hypot(step.x, step.y);
      step.x *= trial_.odometry_scale;
      step.y *= trial_.odometry_scale;
      step.rho += radians(trial_.odometry_drift) * distance / 1000;
      reported_ = reported_ + step;
      driven_ += distance;
    }
    raw_ = now;
    return reported_;
  }
  // Continues at scan `i` without a change of the odometry.
  void carry(std::size_t i) { raw_ = log_.odometry_of(log_.scans[i], trial_.lag); }

  std::span<const BeamEnd> beams(std::size_t i) {
    const LogScan& scan = log_.scans[i];
    log_.beams(scan, beams_);
    for (BeamEnd& beam : beams_) {
      if (trial_.short_beams <= 0 || random_.uniform() >= trial_.short_beams) continue;
      const float part = random_.uniform(0.1F, 0.9F);
      beam.x =
          static_cast<float>(scan.laser.x) + part * (beam.x - static_cast<float>(scan.laser.x));
      beam.y =
          static_cast<float>(scan.laser.y) + part * (beam.y - static_cast<float>(scan.laser.y));
    }
    return beams_;
  }
  [[nodiscard]] double driven() const { return driven_; }  // mm

 private:
  const Trial& trial_;
  const CarmenLog& log_;
  Random random_;
  std::optional<Pose> raw_;
  Pose reported_{};
  double driven_ = 0;
  std::vector<BeamEnd> beams_;
};

class Ours final : public Contestant {
 public:
  Ours(const Trial& trial, const LikelihoodField& field)
      : field_(field), walls_(trial.walls), localiser_(trial.settings, trial.seed) {}

  void start_at(const Pose& pose, double deviation, double deviation_rho) override {
    localiser_.start_at(pose, deviation, deviation_rho);
  }
  void start_anywhere() override { localiser_.start_anywhere(); }
  bool take(const Pose& odometry, const LogScan& /*scan*/,
            std::span<const BeamEnd> beams) override {
    return localiser_.take(field_, odometry, beams, walls_);
  }
  [[nodiscard]] Pose pose() const override { return localiser_.pose(); }
  [[nodiscard]] double share() const override { return localiser_.estimate().share; }
  [[nodiscard]] bool searches() const override { return localiser_.filter().injected() > 0; }

 private:
  const LikelihoodField& field_;
  const localisation::WallLines* walls_;
  Localiser localiser_;
};

// The pose at the first scan: found by a later global start and traced back.
std::optional<Pose> find_start(const Trial& trial, const CarmenLog& log,
                               const LikelihoodField& field) {
  Localiser localiser(trial.settings, trial.seed);
  localiser.start_anywhere();
  Trial plain;
  plain.lag = trial.lag;
  Drive drive(plain, log);
  const Pose first = drive.odometry(0);
  std::uint32_t sure = 0;
  for (std::size_t i = 0; i < log.scans.size(); ++i) {
    const Pose odometry = drive.odometry(i);
    if (!localiser.take(field, odometry, drive.beams(i), trial.walls)) continue;
    sure = localiser.estimate().share > kSureShare ? sure + 1 : 0;
    if (sure == kSureUpdates) return localiser.pose() + (first - odometry);
  }
  return std::nullopt;
}

class Evaluation {
 public:
  Evaluation(const Trial& trial, const CarmenLog& log, const LikelihoodField& field,
             const Truth& truth, const Stopwatch& stopwatch, Contestant& contestant)
      : trial_(trial),
        log_(log),
        field_(field),
        truth_(truth),
        stopwatch_(stopwatch),
        contestant_(contestant),
        drive_(trial, log) {}

  Outcome run() {
    start();
    for (std::size_t i = first_; i < log_.scans.size() && !has_ended(); ++i) {
      if (trial_.kidnap && i == trial_.kidnap->leave && !carried_at_) {
        i = trial_.kidnap->arrive;
        drive_.carry(i);
        at_ = static_cast<std::size_t>(
            std::ranges::lower_bound(truth_.poses, i, {}, &TruePose::scan) - truth_.poses.begin());
        carried_at_ = drive_.driven();
      }
      step(i);
    }
    if (!truth_.relations.empty()) compare_relations();
    return finish();
  }

 private:
  void start() {
    at_ = std::min(trial_.begin, truth_.poses.size());
    const bool knows = at_ < truth_.poses.size();
    first_ = knows && (at_ > 0 || !trial_.global) ? truth_.poses[at_].scan : 0;
    if (trial_.global) return contestant_.start_anywhere();
    std::optional<Pose> at;
    if (!knows) {
      at = find_start(trial_, log_, field_);
    } else {
      at = robot(truth_.poses[at_].laser, first_);
    }
    if (!at) return contestant_.start_anywhere();
    Random random(trial_.seed);
    const double direction = static_cast<double>(random.uniform(0, static_cast<float>(2 * kPi)));
    at->x += kStartDistance * std::cos(direction);
    at->y += kStartDistance * std::sin(direction);
    at->rho += random.uniform() < 0.5F ? -kStartTurn : kStartTurn;
    contestant_.start_at(*at, kStartDistance, kStartTurn);
  }

  [[nodiscard]] bool has_ended() const {
    const bool waits = trial_.kidnap && !carried_at_;
    return !waits && drive_.driven() - carried_at_.value_or(0) > trial_.distance_max * 1000;
  }

  [[nodiscard]] Pose robot(const Pose& laser, std::size_t scan) const {
    return laser + (Pose{} - log_.scans[scan].laser);
  }

  void step(std::size_t i) {
    const Pose odometry = drive_.odometry(i);
    const auto beams = drive_.beams(i);
    const double before = stopwatch_();
    if (contestant_.take(odometry, log_.scans[i], beams)) {
      us_ += stopwatch_() - before;
      ++outcome_.updates;
      if (contestant_.searches()) ++outcome_.recoveries;
    }
    if (trial_.keep_poses) keep(i, odometry);
    const Pose laser = contestant_.pose() + log_.scans[i].laser;
    if (!truth_.relations.empty()) {
      sure_ = sure_ || !trial_.global || contestant_.share() > kSureShare;
      track_.resize(log_.scans.size());
      if (sure_) track_[i] = laser;
    }
    for (; at_ < truth_.poses.size() && truth_.poses[at_].scan <= i; ++at_)
      if (truth_.poses[at_].scan == i && (trial_.global || i != first_))
        compare(error_of(laser, truth_.poses[at_].laser));
  }

  void keep(std::size_t i, const Pose& odometry) {
    PoseRow row{log_.scans[i].logger_time, contestant_.pose(), odometry, {}};
    const auto known = std::ranges::lower_bound(truth_.poses, i, {}, &TruePose::scan);
    if (known != truth_.poses.end() && known->scan == i) row.truth = robot(known->laser, i);
    if (outcome_.poses.empty()) placed_ = row.truth.value_or(row.estimate) + (Pose{} - odometry);
    row.odometry = placed_ + odometry;
    outcome_.poses.push_back(row);
  }

  void compare(const PoseError& error) {
    if (carried_at_ && !outcome_.refound_after && error.near())
      outcome_.refound_after = (drive_.driven() - *carried_at_) / 1000;
    if (trial_.global && !outcome_.found_after) {
      if (!error.near()) return;
      outcome_.found_after = drive_.driven() / 1000;
    }
    add(error);
  }

  void add(const PoseError& error) {
    outcome_.metres.push_back(error.distance / 1000);
    outcome_.degrees.push_back(degrees(error.turn));
    outcome_.lost = !error.near();
  }

  void compare_relations() {
    for (const Relation& relation : truth_.relations) {
      const auto& from = track_[relation.from];
      const auto& to = track_[relation.to];
      if (from && to) add(error_of(*to - *from, relation.step));
    }
  }

  Outcome finish() {
    const auto over = std::ranges::count_if(outcome_.metres, [](double m) { return m > 1; });
    if (!outcome_.metres.empty())
      outcome_.share_over_1m =
          static_cast<double>(over) / static_cast<double>(outcome_.metres.size());
    outcome_.lost = outcome_.lost || outcome_.metres.empty();
    if (outcome_.updates > 0) outcome_.us_per_update = us_ / static_cast<double>(outcome_.updates);
    return std::move(outcome_);
  }

  const Trial& trial_;
  const CarmenLog& log_;
  const LikelihoodField& field_;
  const Truth& truth_;
  const Stopwatch& stopwatch_;
  Contestant& contestant_;
  Drive drive_;
  Outcome outcome_;
  std::vector<std::optional<Pose>> track_;  // of the laser, by scan
  std::size_t first_ = 0;
  std::size_t at_ = 0;                // index of the next true pose
  std::optional<double> carried_at_;  // mm driven
  Pose placed_{};                     // the frame of the odometry
  bool sure_ = false;
  double us_ = 0;
};

}  // namespace

std::optional<Kidnapping> kidnapping(const Truth& truth) {
  const auto& poses = truth.poses;
  for (std::size_t from = poses.size() / 2; from < poses.size(); ++from)
    for (std::size_t to = from; to < poses.size(); ++to)
      if (error_of(poses[from].laser, poses[to].laser).distance >= kCarried)
        return Kidnapping{poses[from].scan, poses[to].scan};
  return std::nullopt;
}

std::vector<Journey> journeys(const Truth& truth, std::size_t count, std::uint64_t seed) {
  constexpr double kBefore = 30000;  // mm
  constexpr double kAfter = 20000;
  constexpr int kTries = 10000;  // data of a single room may have none
  const auto& poses = truth.poses;
  std::vector<double> travelled(poses.size());
  for (std::size_t i = 1; i < poses.size(); ++i)
    travelled[i] = travelled[i - 1] + error_of(poses[i].laser, poses[i - 1].laser).distance;
  Random random(seed);
  std::vector<Journey> found;
  for (int i = 0; i < kTries && found.size() < count && !poses.empty(); ++i) {
    const std::size_t leave = random.below(static_cast<std::uint32_t>(poses.size()));
    const std::size_t arrive = random.below(static_cast<std::uint32_t>(poses.size()));
    const bool has_room =
        travelled[leave] >= kBefore && travelled.back() - travelled[arrive] >= kAfter;
    if (!has_room || error_of(poses[leave].laser, poses[arrive].laser).distance < kCarried)
      continue;
    const auto begin =
        std::ranges::upper_bound(travelled, travelled[leave] - kBefore) - travelled.begin();
    found.push_back({.begin = static_cast<std::size_t>(begin) - 1,
                     .kidnapping = {poses[leave].scan, poses[arrive].scan}});
  }
  return found;
}

Outcome run(const Trial& trial, const CarmenLog& log, const LikelihoodField& field,
            const Truth& truth, const Stopwatch& stopwatch) {
  Ours ours(trial, field);
  return run(trial, log, field, truth, stopwatch, ours);
}

Outcome run(const Trial& trial, const CarmenLog& log, const LikelihoodField& field,
            const Truth& truth, const Stopwatch& stopwatch, Contestant& contestant) {
  return Evaluation(trial, log, field, truth, stopwatch, contestant).run();
}

std::string to_csv(std::span<const PoseRow> poses) {
  std::string text = "time_s";
  for (const char* name : {"", "odometry_", "truth_"})
    text += fmt::format(",{0}x_m,{0}y_m,{0}heading_deg", name);
  text += ",error_m,error_deg\n";
  const auto fields = [](const Pose& pose) {
    return fmt::format(",{:.3f},{:.3f},{:.2f}", pose.x / 1000, pose.y / 1000,
                       degrees(heading(pose.rho)));
  };
  for (const PoseRow& row : poses) {
    text += fmt::format("{:.3f}", row.time) + fields(row.estimate) + fields(row.odometry);
    if (!row.truth) {
      text += ",,,,,\n";
      continue;
    }
    const PoseError error = error_of(row.estimate, *row.truth);
    text += fields(*row.truth) +
            fmt::format(",{:.4f},{:.3f}\n", error.distance / 1000, degrees(error.turn));
  }
  return text;
}

}  // namespace rack::mcl_eval

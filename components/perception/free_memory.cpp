#include "components/perception/free_memory.h"

#include <algorithm>
#include <cmath>

#include "components/perception/pose_search.h"

namespace rack::perception {
namespace {

constexpr double kBetween = 0.4;      // s, between two that are kept
constexpr double kYoungest = 0.35;    // s: a younger one saw what walks where it is
constexpr double kOldest = 8;         // s: the odometry has drifted
constexpr double kBeyond = 200;       // mm that it saw beyond the point, at least
constexpr double kBeyondPart = 0.03;  // and of the way to it
constexpr double kSamePlace = 150;    // mm
constexpr std::uint8_t kAgreeing = 2;
constexpr double kContradicting = 0.5;  // share of a scan
constexpr int kSightsLeast = 20;
constexpr double kMisfitMost = 300;  // mm, of a beam
constexpr std::size_t kSightsOfSearch = 180;

}  // namespace

FreeMemory::FreeMemory() : frames_(kFramesMax) {
  through_.reserve(decltype(Scan2dData::points)::kMax);
  met_.reserve(decltype(Scan2dData::points)::kMax);
  met_now_.reserve(decltype(Scan2dData::points)::kMax);
  now_.reserve(decltype(Scan2dData::points)::kMax);
}

void FreeMemory::forget() {
  for (Frame& frame : frames_) frame.valid = false;
  any_ = false;
}

// 0 to 4 around the turn, as a place in the table.
std::size_t FreeMemory::direction(double x, double y) {
  const double sum = std::abs(x) + std::abs(y);
  const double part = sum > 0 ? y / sum : 0;
  const double around = x < 0 ? 2 - part : (y < 0 ? 4 + part : part);
  return static_cast<std::size_t>(around * (kDirections / 4.0)) % kDirections;
}

void FreeMemory::compare(const Frame& frame, double age, std::vector<Sight>& sights) {
  for (std::size_t i = 0; i < sights.size(); ++i) {
    Sight& sight = sights[i];
    const double dx = sight.x - frame.x;
    const double dy = sight.y - frame.y;
    const double away = std::sqrt(dx * dx + dy * dy);
    const std::size_t at = direction(dx, dy);
    const auto free = static_cast<double>(frame.free[at]);
    const auto met = static_cast<double>(frame.met[at]);
    now_[i] = sight.hit && free > away * (1 + kBeyondPart) + kBeyond ? 1 : 0;
    met_now_[i] = sight.hit && std::abs(met - away) < kSamePlace ? 1 : 0;
    if (met_now_[i] != 0) sight.stood = std::max(sight.stood, age);
  }
}

void FreeMemory::look(ScanView& scan, double seconds) {
  std::vector<Sight>& sights = scan.sights();
  through_.assign(sights.size(), 0);
  met_.assign(sights.size(), 0);
  now_.assign(sights.size(), 0);
  met_now_.assign(sights.size(), 0);
  const auto hits = std::ranges::count_if(sights, &Sight::hit);
  for (Frame& frame : frames_) {
    if (!frame.valid || seconds - frame.seconds < kYoungest) continue;
    if (seconds - frame.seconds > kOldest) {
      frame.valid = false;
      continue;
    }
    compare(frame, seconds - frame.seconds, sights);
    const auto count = std::ranges::count(now_, 1);
    if (count >= kSightsLeast &&
        static_cast<double>(count) > kContradicting * static_cast<double>(hits)) {
      frame.valid = false;
      continue;
    }
    for (std::size_t i = 0; i < sights.size(); ++i) {
      through_[i] += now_[i];
      met_[i] += met_now_[i];
    }
  }
  for (std::size_t i = 0; i < sights.size(); ++i)
    sights[i].moved = through_[i] >= kAgreeing && through_[i] >= met_[i];
  if (!any_ || seconds - kept_ >= kBetween) keep(scan, seconds);
}

// Along each beam, how far from what a kept scan has met in its direction: of the newest one and of
// one before, since a single one drifts.
double FreeMemory::misfit(const ScanView& scan, const Pose& robot, std::size_t step) const {
  const double c = std::cos(robot.rho);
  const double s = std::sin(robot.rho);
  double sum = 0;
  for (const std::size_t back : {std::size_t{1}, std::size_t{3}}) {
    const Frame& frame = frames_[(next_ + frames_.size() - back) % frames_.size()];
    if (!frame.valid) continue;
    for (std::size_t i = 0; i < scan.sights().size(); i += step) {
      const Sight& sight = scan.sights()[i];
      if (!sight.hit) continue;
      const auto x = static_cast<double>(sight.local_x);
      const auto y = static_cast<double>(sight.local_y);
      const double dx = robot.x + x * c - y * s - frame.x;
      const double dy = robot.y + x * s + y * c - frame.y;
      const auto met = static_cast<double>(frame.met[direction(dx, dy)]);
      if (met > 0) sum += std::min(std::abs(met - std::sqrt(dx * dx + dy * dy)), kMisfitMost);
    }
  }
  return sum;
}

Pose FreeMemory::lay_on(const ScanView& scan, const Pose& robot) const {
  const std::size_t step = scan.sights().size() / kSightsOfSearch + 1;
  return nearest_fit(robot, {}, [&](const Pose& pose) { return misfit(scan, pose, step); });
}

void FreeMemory::keep(const ScanView& scan, double seconds) {
  Frame& frame = frames_[next_];
  next_ = (next_ + 1) % frames_.size();
  frame.seconds = seconds;
  frame.x = scan.scanner().x;
  frame.y = scan.scanner().y;
  frame.valid = true;
  frame.free.fill(0);
  frame.met.fill(0);
  // A beam says it for what lies within its own width and that of its neighbours; where several say
  // something, the shortest counts.
  const double around = std::tan(1.5 * scan.resolution());
  const double within = std::tan(0.5 * scan.resolution());
  const auto say = [](std::array<float, kDirections>& table, double x, double y, double half,
                      float away) {
    const std::size_t to = direction(x - half * y, y + half * x);
    for (std::size_t at = direction(x + half * y, y - half * x);; at = (at + 1) % kDirections) {
      table[at] = table[at] == 0 ? away : std::min(table[at], away);
      if (at == to) break;
    }
  };
  for (const Sight& sight : scan.sights()) {
    const double dx = sight.x - frame.x;
    const double dy = sight.y - frame.y;
    const auto away = static_cast<float>(sight.away);
    say(frame.free, dx, dy, around, away);
    if (sight.hit) say(frame.met, dx, dy, within, away);
  }
  kept_ = seconds;
  any_ = true;
}

}  // namespace rack::perception

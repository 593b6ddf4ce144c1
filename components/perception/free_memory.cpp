#include "components/perception/free_memory.h"

#include <algorithm>
#include <cmath>

#include "components/perception/pose_search.h"

namespace rack::perception {
namespace {

constexpr double kBetween = 0.4;    // s, between two frames
constexpr double kYoungest = 0.35;  // s: a younger frame saw a walking person at the same place
constexpr double kOldest = 25;      // s: then the odometry has drifted
constexpr std::uint8_t kAgreeing = 2;
constexpr double kContradicting = 0.5;  // share of a scan's points
constexpr int kSightsLeast = 20;
constexpr std::array<std::size_t, 4> kLaidOn{0, 2, 8,
                                             16};  // indices of kept scans, the newest is 0
constexpr double kMisfitMost = 300;                // mm, of a beam
constexpr std::size_t kSightsOfSearch = 180;

}  // namespace

FreeMemory::FreeMemory() : frames_(kFramesMax), order_(kFramesMax) {
  std::ranges::generate(order_, [n = std::size_t{0}]() mutable { return n++; });
  through_.reserve(decltype(Scan2dData::points)::kMax);
  met_.reserve(decltype(Scan2dData::points)::kMax);
  met_now_.reserve(decltype(Scan2dData::points)::kMax);
  now_.reserve(decltype(Scan2dData::points)::kMax);
}

void FreeMemory::forget() {
  for (Frame& frame : frames_) frame.valid = false;
  any_ = false;
}

void FreeMemory::compare(const FreeTable& table, const std::vector<Sight>& sights) {
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const Sight& sight = sights[i];
    const double dx = sight.x - table.from().x;
    const double dy = sight.y - table.from().y;
    const double away = std::sqrt(dx * dx + dy * dy);
    const FreeTable::Distances distances = table.towards(dx, dy);
    now_[i] = sight.hit && FreeTable::is_through(distances, away) ? 1 : 0;
    met_now_[i] = sight.hit && FreeTable::is_met(distances, away) ? 1 : 0;
  }
}

void FreeMemory::look(ScanView& scan, double seconds) {
  std::vector<Sight>& sights = scan.sights();
  through_.assign(sights.size(), 0);
  met_.assign(sights.size(), 0);
  now_.assign(sights.size(), 0);
  met_now_.assign(sights.size(), 0);
  const auto hits = std::ranges::count_if(sights, &Sight::hit);
  // Newest first.
  for (const std::size_t at : order_) {
    Frame& frame = frames_[at];
    if (!frame.valid || seconds - frame.seconds < kYoungest) continue;
    if (seconds - frame.seconds > kOldest) {
      frame.valid = false;
      continue;
    }
    compare(frame.table, sights);
    const auto count = std::ranges::count(now_, 1);
    if (count >= kSightsLeast &&
        static_cast<double>(count) > kContradicting * static_cast<double>(hits)) {
      frame.valid = false;
      continue;
    }
    for (std::size_t i = 0; i < sights.size(); ++i) {
      through_[i] += now_[i];
      met_[i] += met_now_[i];
      if (met_now_[i] != 0 && through_[i] < kAgreeing) sights[i].stood = seconds - frame.seconds;
    }
  }
  for (std::size_t i = 0; i < sights.size(); ++i)
    sights[i].moved = through_[i] >= kAgreeing && through_[i] >= met_[i];
  now_table_.fill(scan);
  if (!any_ || seconds - kept_ >= kBetween) keep(seconds);
}

// The mean over the beams of the difference in range to a kept scan in the same direction. The
// mean, since a pose with fewer common beams is not better for it.
double FreeMemory::misfit(const ScanView& scan, const Pose& robot, std::size_t step) const {
  const double c = std::cos(robot.rho);
  const double s = std::sin(robot.rho);
  double sum = 0;
  double count = 0;
  for (const std::size_t back : kLaidOn) {
    const Frame& frame = frames_[order_[back]];
    if (!frame.valid) continue;
    for (std::size_t i = 0; i < scan.sights().size(); i += step) {
      const Sight& sight = scan.sights()[i];
      if (!sight.hit) continue;
      const auto x = static_cast<double>(sight.local_x);
      const auto y = static_cast<double>(sight.local_y);
      const double dx = robot.x + x * c - y * s - frame.table.from().x;
      const double dy = robot.y + x * s + y * c - frame.table.from().y;
      const double met = frame.table.towards(dx, dy).met;
      if (met <= 0) continue;
      sum += std::min(std::abs(met - std::sqrt(dx * dx + dy * dy)), kMisfitMost);
      ++count;
    }
  }
  return count > 0 ? sum / count : 0;
}

Pose FreeMemory::lay_on(const ScanView& scan, const Pose& robot) const {
  const std::size_t step = scan.sights().size() / kSightsOfSearch + 1;
  // A wider search than on a map: when scans are late, a turning robot is several degrees off.
  constexpr PoseSearch kSearch{.step = 80, .step_turn = radians(3.2), .levels = 5};
  return nearest_fit(robot, kSearch, [&](const Pose& pose) { return misfit(scan, pose, step); });
}

void FreeMemory::keep(double seconds) {
  // Among frames that leave the newest ones, every fourth stays; the slot of the others is reused.
  const Frame& passes = frames_[order_[kNewest - 1]];
  const bool stays = passes.valid && passes.number % kOldApart == 0;
  const auto last = order_.begin() + (stays ? kFramesMax : kNewest);
  std::rotate(order_.begin(), last - 1, last);
  Frame& frame = frames_[order_.front()];
  frame.number = next_++;
  frame.seconds = seconds;
  frame.valid = true;
  frame.table = now_table_;
  kept_ = seconds;
  any_ = true;
}

}  // namespace rack::perception

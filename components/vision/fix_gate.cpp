#include "components/vision/fix_gate.h"

#include <algorithm>
#include <cmath>

namespace rack::vision {

namespace {

constexpr double kGate = 3;               // standard deviations
constexpr double kGateMin = 150;          // mm
constexpr double kGateRho = radians(15);  // heading
constexpr double kSame = 300;             // mm, from picture to picture
constexpr double kSameRho = radians(8);

bool is_near(const Pose& a, const Pose& b, double mm, double rho) {
  return std::hypot(a.x - b.x, a.y - b.y) <= mm && std::abs(signed_angle(a.rho - b.rho)) <= rho;
}

}  // namespace

std::optional<RobotFix> FixGate::take(TimeStamp time, std::span<const RobotFix> fixes,
                                      const Pose& believed, double deviation) {
  const auto is_believed = [&](const RobotFix& fix) {
    const double gate = std::max(kGate * std::hypot(fix.deviation, deviation), kGateMin);
    return is_near(fix.pose, believed, gate, kGateRho);
  };
  const auto count = std::ranges::count_if(fixes, is_believed);
  if (count > 0) elsewhere_.reset();
  if (count == 1) {
    const RobotFix& fix = *std::ranges::find_if(fixes, is_believed);
    // It would replace what is known better: by MonteCarloLocalisation, for example.
    return fix.deviation < deviation ? std::optional(fix) : std::nullopt;
  }
  // Of several poses that fit equally, none says where the robot is.
  return count == 0 && fixes.size() == 1 ? elsewhere(time, fixes.front(), believed, deviation)
                                         : std::nullopt;
}

std::optional<RobotFix> FixGate::elsewhere(TimeStamp time, const RobotFix& fix,
                                           const Pose& believed, double deviation) {
  const bool agrees =
      elsewhere_ && is_near(elsewhere_->pose + (believed - elsewhere_->believed), fix.pose,
                            std::max(kSame, kGate * fix.deviation), kSameRho);
  if (!agrees) elsewhere_ = {time, believed, fix.pose, believed, 0};
  elsewhere_->pose = fix.pose;
  elsewhere_->believed = believed;
  ++elsewhere_->pictures;
  const bool has_moved = !is_near(elsewhere_->start, believed, kMoved, kTurned);
  const bool is_doubtful = fix.markers < 2 && deviation < kUncertain && !has_moved;
  const auto needed = is_doubtful ? kSingleAgreesFor : kAgreeingFor;
  if (elsewhere_->pictures < kAgreeing || time - elsewhere_->began < needed) return std::nullopt;
  elsewhere_.reset();
  return fix;
}

}  // namespace rack::vision

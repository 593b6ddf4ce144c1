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

std::optional<RobotFix> FixGate::take(std::span<const RobotFix> fixes, const Pose& believed,
                                      double deviation) {
  for (const RobotFix& fix : fixes) {
    const double gate = std::max(kGate * std::hypot(fix.deviation, deviation), kGateMin);
    if (!is_near(fix.pose, believed, gate, kGateRho)) continue;
    elsewhere_.reset();
    return fix;
  }
  // Of two poses that fit equally, none says where the robot is.
  return fixes.size() == 1 ? elsewhere(fixes.front(), believed) : std::nullopt;
}

std::optional<RobotFix> FixGate::elsewhere(const RobotFix& fix, const Pose& believed) {
  const bool agrees =
      elsewhere_ && is_near(elsewhere_->pose + (believed - elsewhere_->believed), fix.pose,
                            std::max(kSame, kGate * fix.deviation), kSameRho);
  const int pictures = agrees ? elsewhere_->pictures + 1 : 1;
  elsewhere_ = {fix.pose, believed, pictures};
  if (pictures < kAgreeing) return std::nullopt;
  elsewhere_.reset();
  return fix;
}

}  // namespace rack::vision

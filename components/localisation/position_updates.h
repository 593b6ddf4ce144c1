// When MonteCarloLocalisation updates Position, and when it searches where another component, such
// as ObjRecogMarkers, has found the robot. Pure.
//
// While the localiser is certain, Position gets each estimate. While it is not, Position keeps its
// pose, but gets a large standard deviation instead of a small one, so that nobody drives by a pose
// that is only believed: at the start, after the robot was lost, and after Position was restarted.
//
// Position is expected where the last update and the odometry since have taken it. If it is
// elsewhere, and certain, another component has updated it, and the localiser goes on there. A
// Position that has no data of the time of the last look has been restarted instead, and is at its
// origin: it knows less than the localiser.
//
// Who starts where Position is has to know whether Position itself knows: at the origin of a robot
// that has not moved since its start, or somewhere with a deviation. When both programs have been
// restarted on the way, nobody knows.
#pragma once

#include <functional>
#include <optional>

#include "components/localisation/localiser.h"
#include "rack/proxies/position.h"

namespace rack::localisation {

class PositionUpdates {
 public:
  static constexpr double kJump = 300;           // mm: smaller updates by others change nothing
  static constexpr double kCertain = 500;        // mm: larger deviations are not certain
  static constexpr i32 kLostDeviation = 5000;    // mm, at least
  static constexpr double kKnown = 20000;        // mm; above, a position is not known yet
  static constexpr double kFollowedTurn = 0.17;  // rad, deviation of the heading of a followed pose

  enum class Event : std::uint8_t { kNone, kCertain, kUncertain, kFollows };
  struct Step {
    Event event = Event::kNone;
    double away = 0;                       // mm, of a followed pose from the localiser's
    std::optional<PositionData> update{};  // for Position
  };
  // Whether a localiser may start where Position is. `odometry`: of the same time; `deviation`: mm
  // and rad, within which the robot counts as not moved since the odometry began.
  static bool may_start_at(const PositionData& position, const Pose& odometry, double deviation,
                           double deviation_rho);

  // Whether Position has data of a time.
  using KnowsTime = std::function<bool(TimeStamp)>;

  // `odometry`: at the last scan, of `time`; `believed`: Position's data of that time, if it has
  // any. May start the localiser at another place.
  Step take(Localiser& localiser, const Pose& odometry, const std::optional<PositionData>& believed,
            TimeStamp time, const KnowsTime& knows_time);

 private:
  struct Look {
    Pose position;
    Pose odometry;
    TimeStamp time;
  };

  [[nodiscard]] bool has_jumped(const Look& now, const KnowsTime& knows_time) const;
  [[nodiscard]] std::optional<double> followed(Localiser& localiser, const PositionData& believed);

  std::optional<Look> last_{};
  bool was_sure_ = false;
};

}  // namespace rack::localisation

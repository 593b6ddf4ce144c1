// A path to a place, through what is free of a map. Pure.
//
// A car is led by hybrid_search.h. One that turns at rest goes along the cells (grid_search.h): of
// that way the corners stay that are needed to see from one to the next, and between them it drives
// straight. It is looked for with room to turn everywhere; if there is none, with room to drive
// through, and room to turn only where it has to.
#pragma once

#include <string>
#include <vector>

#include "components/path/hybrid_search.h"
#include "components/path/path_maker.h"

namespace rack::path {

struct PlanSettings {
  PathLimits limits{};     // radius_min 0: it turns at rest
  HullDiscs::Size hull{};  // with the margin that a plan keeps
  double comfort = 300;    // mm, of room that it would rather have, too
};

class GoalPlanner {
 public:
  using Progress = HybridSearch::Progress;

  // What the vehicle is; takes the memory.
  explicit GoalPlanner(const PlanSettings& settings);
  // Other speeds; the vehicle stays what it is.
  void set_limits(const PathLimits& limits);

  // sense -1: it shall drive backward where it has the choice. `speed`: a limit, 0: none. The
  // error says where there is no room. `space` has to live as long as the search.
  tims::Result<void> begin(const FreeSpace& space, const Pose& start, const Pose& goal,
                           double sense = 1, double speed = 0);
  // So much work at a time that a period of 50 ms has room for it.
  Progress advance(int poses = 1000);
  // After kFound.
  [[nodiscard]] const std::vector<PolarSpline>& path() const { return path_; }
  // After kFailed.
  [[nodiscard]] const std::string& why() const { return why_; }

 private:
  Progress over_cells();
  bool corners(double room);
  [[nodiscard]] std::size_t next_corner(std::size_t from, double room) const;
  Progress fail(std::string why);
  tims::Result<void> lay_waypoints(double room, bool rounds);
  void lay_pieces();

  PlanSettings settings_;
  HullDiscs hull_;
  const FreeSpace* space_ = nullptr;
  Pose start_{};
  Pose goal_{};
  double sense_ = 1;
  double speed_ = 0;
  GridSearch cells_;
  HybridSearch poses_;
  std::vector<Place> way_;
  std::vector<Place> corners_;
  std::vector<PolarSpline> path_;
  std::string why_;
};

}  // namespace rack::path

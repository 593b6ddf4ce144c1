// Plans a path to a destination through the free space of a map. Pure.
//
// For a vehicle with a minimum turning radius, hybrid_search.h finds the path. For one that turns
// at rest, the path is searched over the cells (grid_search.h) and reduced to the corners with a
// free line of sight between them, which are joined by straight lines. The first search requires
// room to turn everywhere; if it fails, the second one requires room to pass, and room to turn only
// at the corners. A vehicle that stands nearer to an obstacle than that, such as a person who has
// come to it, may leave the place if it comes no nearer; if it cannot even turn there, it first
// goes back. The last leg gives the final heading; it begins where the vehicle can turn.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "components/path/hybrid_search.h"
#include "components/path/path_maker.h"

namespace rack::path {

struct PlanSettings {
  PathLimits limits{};     // radius_min 0: the vehicle turns at rest
  HullDiscs::Size hull{};  // including the margin that a plan keeps
  double comfort = 300;    // mm, additional clearance that is preferred
};

class GoalPlanner {
 public:
  using Progress = HybridSearch::Progress;

  // Takes the properties of the vehicle; allocates the memory.
  explicit GoalPlanner(const PlanSettings& settings);
  // Changes the speeds; the vehicle's geometry stays.
  void set_limits(const PathLimits& limits);

  // `sense` -1: prefers driving backward. `speed`: limit, 0: none. The error names the place
  // without room. `space` must outlive the search.
  tims::Result<void> begin(const FreeSpace& space, const Pose& start, const Pose& goal,
                           double sense = 1, double speed = 0);
  // Expands `poses` poses; the default takes less than a period of 50 ms.
  Progress advance(int poses = 1000);
  // After kFound.
  [[nodiscard]] const std::vector<PolarSpline>& path() const { return path_; }
  // After kFailed.
  [[nodiscard]] const std::string& why() const { return why_; }

 private:
  Progress over_cells();
  bool corners(const Place& start, double room);
  void go_back_to_turn(double room);
  [[nodiscard]] std::optional<Place> back_where_it_turns() const;
  [[nodiscard]] std::size_t next_corner(std::size_t from, double room) const;
  [[nodiscard]] double room_to_leave(const Place& start) const;
  [[nodiscard]] Place before_goal() const;
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
  std::vector<Place> cells_on_path_;
  std::vector<Place> corners_;
  bool goes_back_ = false;  // from the start to the first corner
  std::vector<PolarSpline> path_;
  std::string why_;
};

}  // namespace rack::path

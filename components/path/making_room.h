// When and where a vehicle makes room for somebody who comes towards it. Pure.
//
// A vehicle whose path is blocked, and that finds none around, may itself block the path of the
// person who stands there: in a door, both would wait for ever. So it drives to a place aside
// (place_aside.h), waits there until there is a path again, or for some time, and drives on. It
// does so, too, before a detour that is much longer than the blocked path, at each place once. This
// is repeated a few times only: what never goes is not a person.
//
// This class decides; `RoutePlanner` plans the paths to the place and from there.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "components/path/detour.h"
#include "components/path/place_aside.h"
#include "rack/proxies/chassis.h"

namespace rack::path {

class MakingRoom {
 public:
  enum class Phase : std::uint8_t { kNo, kPlans, kDrives, kWaits };
  enum class Look : std::uint8_t { kNot, kForAPath, kAsIfItHadGone };

  MakingRoom();  // allocates all memory

  void begin(const ChassisParamData& chassis);  // forgets everything
  void begin_destination();                     // forgets all but the trail
  void end() { phase_ = Phase::kNo; }
  void follow(const Pose& robot);

  [[nodiscard]] Phase phase() const { return phase_; }
  [[nodiscard]] bool is_active() const { return phase_ != Phase::kNo; }

  // --- the path is blocked at a place of it, or nothing is known to block it

  void block(const OnPath& at, double direct);  // `direct`: mm, from there to the destination
  void unblock() { blocked_at_.reset(); }
  [[nodiscard]] const std::optional<OnPath>& blocked_at() const { return blocked_at_; }
  // Plans do not help a vehicle that has not moved since the last one. To be asked once a plan.
  [[nodiscard]] bool is_stuck(const Pose& robot);
  [[nodiscard]] bool is_long_detour(double length) const;
  // It has made room here before, for a detour.
  [[nodiscard]] bool has_offered(const Pose& robot) const;
  void offer(const Pose& robot) { offered_at_ = {robot.x, robot.y}; }

  // --- making room

  // The path is blocked, and the vehicle was not aside too often.
  [[nodiscard]] bool may_begin() const;
  // Precondition: may_begin(). Finds a place beside `path` in `space`. False: there is none.
  bool begin_aside(const FreeSpace& space, std::span<const PolarSpline> path, const Pose& robot);
  // Somebody blocks the path to the place: it is planned again, in the other direction of travel.
  void turn_around();
  // There is a path to the place; `is_first`: not on the way to it already.
  void drive(bool is_first);
  // One period while it drives or waits.
  Look step(TimeStamp now, const Pose& robot);

  [[nodiscard]] const Pose& place() const { return place_; }
  [[nodiscard]] double sense() const { return sense_; }  // of the path to the place
  // From the place to where the path is blocked, mm.
  [[nodiscard]] double to_blocked() const;

 private:
  [[nodiscard]] std::optional<Place> find(const FreeSpace& space, std::span<const PolarSpline> path,
                                          const Pose& robot);

  ChassisParamData chassis_{};
  Phase phase_ = Phase::kNo;
  std::optional<OnPath> blocked_at_;   // since the last new path
  double direct_ = 0;                  // mm
  std::optional<Place> replanned_at_;  // where the vehicle was
  std::optional<Place> offered_at_;
  Pose place_;
  Pose left_;  // where the vehicle was
  double sense_ = 1;
  int times_ = 0;         // on the way to this destination
  TimeStamp since_ = 0;   // it drives, or waits
  TimeStamp looked_ = 0;  // for a path to the destination
  std::vector<Place> trail_;
  std::vector<Place> lane_;  // buffer: the trail, and the path ahead
  GridSearch reach_;
};

}  // namespace rack::path

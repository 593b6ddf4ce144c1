// A scan of space from a ladar that an axis turns or tilts. Pure.
//
// Each distance is a place in the plane of the ladar. The axis has turned this plane, and the robot
// has driven on, while the ladar's mirror went around: so every point is placed by the angle of the
// axis and the pose of the robot at its own moment (deskewing). Both are known by samples from
// before and after it (track.h); scans wait until those have come. Points are kept in the frame of
// the robot at the beginning of the sweep, and are said in the frame of the moment when a message
// is made: its reference position.
//
// A sweep goes from one end of the span to the other, to and fro or always the same way round.
// The span is divided into as many cells as there may be flat scans, and each cell takes the first
// flat scan that falls into it: a slow axis makes no message too long, and a fast one only leaves
// cells out. The sweep is sent in sectors while it is made, and as a whole at its end when it was
// seen from end to end. After O. Wulf and B. Wagner, "Fast 3D scanning methods for laser
// measurement systems", 2003.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "components/scan3d/frame.h"
#include "components/scan3d/trajectory.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/scan3d.h"

namespace rack::scan3d {

struct SweepMounting {
  // One of scan_mode: about which axis the ladar turns, and how it is built on. Roll: about x;
  // pitch: about y; both with the ladar's plane level. Yaw: about z, the plane upright, ahead the
  // ladar's front; top, top-down: alike, its front upwards, downwards.
  i32 mode = scan_mode::kPitch;
  Pose axis{};           // the axis on the robot, at angle 0
  Place ladar{};         // on what turns, mm
  double ladar_rho = 0;  // where its front looks in its plane, clockwise, rad
  bool upside_down = false;
  bool is_reversed = false;  // the last point is measured first
};

struct SweepSettings {
  SweepMounting mounting{};
  double from = -0.8;              // the span, rad of the axis
  double to = 0.8;                 // more than `from`
  bool is_round = false;           // the axis goes round and round: each such span is a sweep
  std::size_t scans_max = 400;     // flat scans of a sweep
  std::size_t points_max = 72400;  // of a message; fewer flat scans when theirs are many
  i32 sectors = 1;                 // messages of a sweep, beside the whole; 1: only that
  std::size_t reduce = 1;          // each so many-th point
  i32 range_min = 0;               // mm; nearer is the robot itself
  i32 range_max = 0;               // mm; 0: as the ladar
  double lag_ms = 0;               // the ladar's times are later than what it measured
  double duration_ms = -1;         // of a flat scan; below 0: as the ladar says
  bool has_poses = false;          // of the robot; otherwise it stands
};

// Flat scans that did not become part of a sweep.
struct SweepLosses {
  std::uint64_t unplaced = 0;  // nobody knows where axis or robot were
  std::uint64_t crowded = 0;   // did not wait any longer: too many came meanwhile
  std::uint64_t broken = 0;    // longer than a second, or without points
};

class Sweep {
 public:
  // Allocates all that it ever needs.
  explicit Sweep(const SweepSettings& settings);

  // False: they are no numbers, or older than all others.
  bool add_axis(TimeStamp time, double angle) { return axis_.add(time, angle); }
  bool add_pose(TimeStamp time, const Position3d& pose) { return poses_.add(time, Pose::of(pose)); }
  void add(const LadarData& scan);

  // When the first scan that waits began and ended: what has to be asked for.
  struct Span {
    TimeStamp begin;
    TimeStamp end;
  };
  [[nodiscard]] std::optional<Span> wanted() const;

  // The next message, if there is one: all but its `recordingTime` of the newest flat scan and
  // `refPos`, where the robot was then, is of the sweep or its sector. Call it until it is false.
  // Allocates nothing once `scan` has the room.
  bool next(Scan3dData& scan);

  // Of the axis: 1 it rises, -1 it falls, 0 not known yet.
  [[nodiscard]] int direction() const { return direction_; }
  [[nodiscard]] const SweepLosses& losses() const { return losses_; }

 private:
  static constexpr std::size_t kWaitingMax = 32;

  struct Stored {
    float x = 0;  // mm, in the frame of the sweep's beginning
    float y = 0;
    float z = 0;
    i32 type = 0;
    i16 intensity = 0;
  };
  // Where axis and robot were while a flat scan was made.
  struct Course {
    TimeStamp time = 0;  // its middle
    double half_ms = 0;
    double axis_begin = 0;
    double axis_end = 0;
    Pose begin{};
    Pose middle{};
    Pose end{};
    [[nodiscard]] double axis() const { return (axis_begin + axis_end) / 2; }
  };
  struct Part {             // of the sweep: a sector, or all of it
    std::size_t point = 0;  // its first
    i32 scans = 0;
    TimeStamp begin = 0;
  };
  enum class Found : std::uint8_t { kYes, kNotYet, kNever };

  [[nodiscard]] const LadarData& oldest() const { return waiting_[first_]; }
  void drop_oldest();
  [[nodiscard]] double half_of(const LadarData& scan) const;
  [[nodiscard]] TimeStamp middle_of(const LadarData& scan) const;
  Found find(const LadarData& scan, Course& course) const;

  // False: a message has to be sent before the scan can be taken.
  bool take(const LadarData& scan, const Course& course);
  bool follow_direction(double axis);
  bool follow_round(double axis);
  [[nodiscard]] double progress(double axis) const;
  void end_sweep();
  void begin_sweep(const LadarData& scan, const Course& course);
  void put_points(const LadarData& scan, const Course& course);
  void put_point(const LadarPoint& point, i32 range_max, const Frame& ladar);
  [[nodiscard]] Frame ladar_at(const Course& course, double part) const;

  void fill(const Part& part, Scan3dData& scan) const;
  [[nodiscard]] i32 mode() const;

  SweepSettings settings_;
  Frame mounting_;
  Place ahead_{};  // of the ladar's plane, on what turns
  Place right_{};

  Track<double> axis_;
  Track<Pose> poses_;
  std::vector<LadarData> waiting_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;

  int direction_ = 0;
  std::optional<double> farthest_{};  // of the axis in this direction
  double turn_ = 0;                   // of an axis that goes round: which span
  std::vector<Stored> points_;
  std::size_t size_ = 0;
  std::size_t line_points_ = 0;
  i32 line_range_ = 0;  // mm
  std::int64_t cells_ = 1;
  std::int64_t last_cell_ = -1;  // those up to it are closed
  std::int64_t first_cell_ = 0;  // of those that were filled
  std::int64_t end_cell_ = 0;
  i32 mode_ = 0;       // of the sweep
  Frame to_origin_{};  // from the world to the robot at the beginning of the sweep
  Course last_{};      // of the scan that was taken last
  Part sweep_{};
  Part sector_{};
  i32 sector_index_ = 0;
  bool is_sector_due_ = false;
  bool is_sweep_due_ = false;
  SweepLosses losses_{};
};

}  // namespace rack::scan3d

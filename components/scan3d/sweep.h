// A 3D scan from a ladar that an axis turns or tilts. Pure.
//
// Each range is a point in the plane of the ladar. While the mirror of the ladar rotates, the axis
// turns this plane and the robot moves, so every point is transformed by the angle of the axis and
// the pose of the robot at its own time (deskewing). Both are interpolated from samples before and
// after it (trajectory.h); scans are queued until those have arrived. Points are stored in the
// frame of the robot at the start of the sweep, and are sent in the frame of the reference
// position: that of the robot when the message is built.
//
// A sweep goes from one end of the span to the other, to and fro or always in the same direction.
// The span is divided into as many cells as the maximum number of flat scans, and each cell takes
// the first flat scan that falls into it: a slow axis does not make a message too long, and a fast
// one leaves cells empty. The sweep is sent in sectors while it is built, and as a whole at its end
// if the whole span was seen. After O. Wulf and B. Wagner, "Fast 3D scanning methods for laser
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
  // One of scan_mode: the axis that the ladar turns about, and its mounting. Roll: about x; pitch:
  // about y; both with the ladar's plane level. Yaw: about z, the plane upright, the front of the
  // ladar forward; top, top-down: the same with its front up or down.
  i32 mode = scan_mode::kPitch;
  Pose axis{};           // the axis on the robot, at angle 0
  Place ladar{};         // relative to the axis, mm
  double ladar_rho = 0;  // direction of its front in its plane, clockwise, rad
  bool upside_down = false;
  bool is_reversed = false;  // the last point is measured first
};

struct SweepSettings {
  SweepMounting mounting{};
  double from = -0.8;              // the span, rad of the axis
  double to = 0.8;                 // more than `from`
  bool is_round = false;           // the axis turns continuously: each such span is a sweep
  std::size_t scans_max = 400;     // maximum number of flat scans of a sweep
  std::size_t points_max = 72400;  // of a message; limits the number of flat scans
  i32 sectors = 1;                 // partial messages per sweep; 1: only the whole
  std::size_t reduce = 1;          // every n-th point is used
  i32 range_min = 0;               // mm; nearer is the robot itself
  i32 range_max = 0;               // mm; 0: range of the ladar
  double lag_ms = 0;               // delay of the ladar's time stamps
  double duration_ms = -1;         // of a flat scan; below 0: as reported by the ladar
  bool has_poses = false;          // poses of the robot are available; otherwise it stands still
};

// Flat scans that did not become part of a sweep.
struct SweepLosses {
  std::uint64_t unplaced = 0;  // the pose of axis or robot is not known
  std::uint64_t crowded = 0;   // the queue was full
  std::uint64_t broken = 0;    // longer than a second, or without points
};

class Sweep {
 public:
  // Allocates all memory.
  explicit Sweep(const SweepSettings& settings);

  // False: the sample is not a number, or older than all others.
  bool add_axis(TimeStamp time, double angle) { return axis_.add(time, angle); }
  bool add_pose(TimeStamp time, const Position3d& pose) { return poses_.add(time, Pose::of(pose)); }
  void add(const LadarData& scan);

  // Start and end of the first scan in the queue: the times to request samples for.
  struct Span {
    TimeStamp begin;
    TimeStamp end;
  };
  [[nodiscard]] std::optional<Span> wanted() const;

  // Builds the next message, if there is one. `recordingTime` is that of the newest flat scan and
  // `refPos` the pose of the robot then; all other fields are those of the sweep or its sector.
  // Call it until it returns false. Allocates nothing when `scan` has capacity.
  bool next(Scan3dData& scan);

  // Direction of the axis: 1 rising, -1 falling, 0 not known yet.
  [[nodiscard]] int direction() const { return direction_; }
  [[nodiscard]] const SweepLosses& losses() const { return losses_; }

 private:
  static constexpr std::size_t kWaitingMax = 32;

  struct Stored {
    float x = 0;  // mm, in the robot's frame at the start of the sweep
    float y = 0;
    float z = 0;
    i32 type = 0;
    i16 intensity = 0;
  };
  // Poses of axis and robot during a flat scan.
  struct Course {
    TimeStamp time = 0;  // middle of the scan
    double half_ms = 0;
    double axis_begin = 0;
    double axis_end = 0;
    Pose begin{};
    Pose middle{};
    Pose end{};
    [[nodiscard]] double axis() const { return (axis_begin + axis_end) / 2; }
  };
  struct Part {             // a sector of the sweep, or all of it
    std::size_t point = 0;  // index of its first point
    i32 scans = 0;
    TimeStamp begin = 0;
  };
  enum class Found : std::uint8_t { kYes, kNotYet, kNever };

  [[nodiscard]] const LadarData& oldest() const { return waiting_[first_]; }
  void drop_oldest();
  [[nodiscard]] double half_of(const LadarData& scan) const;
  [[nodiscard]] TimeStamp middle_of(const LadarData& scan) const;
  Found find(const LadarData& scan, Course& course) const;

  // False: a message has to be sent before the scan can be used.
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
  Place ahead_{};  // forward direction of the ladar's plane, in the frame of the axis
  Place right_{};

  Trajectory<double> axis_;
  Trajectory<Pose> poses_;
  std::vector<LadarData> waiting_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;

  int direction_ = 0;
  std::optional<double> farthest_{};  // farthest angle in this direction
  double turn_ = 0;                   // index of the span, for an axis that turns continuously
  std::vector<Stored> points_;
  std::size_t size_ = 0;
  std::size_t line_points_ = 0;
  i32 line_range_ = 0;  // mm
  std::int64_t cells_ = 1;
  std::int64_t last_cell_ = -1;  // cells up to it are closed
  std::int64_t first_cell_ = 0;  // first cell that was filled
  std::int64_t end_cell_ = 0;
  i32 mode_ = 0;       // of the sweep
  Frame to_origin_{};  // from the world to the robot at the start of the sweep
  Course last_{};      // of the last scan used
  Part sweep_{};
  Part sector_{};
  i32 sector_index_ = 0;
  bool is_sector_due_ = false;
  bool is_sweep_due_ = false;
  SweepLosses losses_{};
};

}  // namespace rack::scan3d

// One tracked object: its position, speed, size and kind. Pure.
//
// The motion model is a Kalman filter with constant velocity and random acceleration; north and
// east have the same noise, so that one 2 x 2 covariance serves both. Scanners see sides and not
// centres: the corner of a box that is nearest to the scanner is used, and the centre follows from
// the largest length and width seen so far.
//
// A static object has an apparent speed due to noise. An object counts as moving when it is faster
// than the noise, has left the place where it stood, and is at a place that earlier scans saw as
// free; and when later scans see through the places where it was. An artefact that slides along a
// wall leaves the wall behind, and where beams alternate between many thin furniture legs, each
// place is hit again. It counts as standing again when it is slow.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "components/perception/clusters.h"
#include "components/perception/free_table.h"

namespace rack::perception {

enum class ObjectKind : std::uint8_t {
  kUnclassified,
  kSmall,
  kBig,
  kPedestrian,
  kBike,
  kCar,
  kTruck
};

// The measurement of an object by one scan.
struct Sighting {
  Box box{};
  double deviation = 0;  // mm, of its centre
  double moved = 0;      // share of its points that have moved
  bool person = false;   // at most as large as a person
  bool leg = false;      // as narrow as a leg
  bool pair = false;     // two legs
  MapPoint point{};      // end point of its central beam
  MapPoint scanner{};    // position of the scanner
};

class Track {
 public:
  Track(std::int32_t id, const Sighting& sighting, double seconds);

  void predict(double seconds);
  // Checks the earlier positions of the object against the scan.
  void look_back(const FreeTable& now);
  // After predict() and look_back(): one of update() and miss().
  void update(const Sighting& sighting);
  // `through`: the scan saw through the place where the object should be.
  void miss(bool through);

  [[nodiscard]] std::int32_t id() const { return id_; }
  [[nodiscard]] MapPoint at() const { return {x_.value, y_.value}; }
  [[nodiscard]] MapPoint velocity() const { return {x_.rate, y_.rate}; }  // mm/s
  [[nodiscard]] double speed() const;
  [[nodiscard]] double deviation() const;        // mm
  [[nodiscard]] double speed_deviation() const;  // mm/s
  // For a person: including a stride.
  [[nodiscard]] double length() const;
  [[nodiscard]] double width() const;
  [[nodiscard]] double heading() const { return heading_; }
  [[nodiscard]] double probability() const;
  [[nodiscard]] ObjectKind kind() const;

  [[nodiscard]] bool person() const { return person_; }
  [[nodiscard]] bool confirmed() const { return confirmed_; }
  // Confirmed, and seen within the last half second.
  [[nodiscard]] bool published() const;
  [[nodiscard]] bool moving() const { return moving_; }
  [[nodiscard]] bool ever_moved() const { return ever_moved_; }
  // Most scans show only one leg.
  [[nodiscard]] bool one_leg() const { return one_leg_ > 0.5; }
  [[nodiscard]] bool seen_now() const { return (hits_ & 1U) != 0; }
  // The tracker can drop it.
  [[nodiscard]] bool lost() const;
  // The cluster was at its place before this object came: it is another one.
  [[nodiscard]] bool is_other(const Cluster& cluster) const;
  // s since it was last seen, and since it was last at a place that earlier scans saw as free.
  [[nodiscard]] double unseen() const { return now_ - seen_; }
  [[nodiscard]] double unmoved() const { return now_ - moved_; }

  // Squared distance in standard deviations.
  [[nodiscard]] double mahalanobis(const Cluster& cluster, double deviation) const;

 private:
  struct Axis {
    double value = 0;
    double rate = 0;
  };
  void correct(const MapPoint& measured, double deviation);
  [[nodiscard]] Box align(const Box& box) const;
  [[nodiscard]] MapPoint centre_of(const Box& aligned, const MapPoint& scanner) const;
  // The number of the last `scans` (at most 32) that showed it.
  [[nodiscard]] int hits_of(unsigned scans) const;
  void learn_size(const Box& aligned);
  void judge_movement(const Sighting& sighting);
  void leave_trace(const MapPoint& point);
  [[nodiscard]] bool has_left() const;

  struct Trace {
    MapPoint at{};
    unsigned through = 0;  // number of scans that saw through it since
    bool met = false;      // a scan hit something there
  };
  static constexpr std::size_t kTracesMax = 8;

  std::int32_t id_;
  Axis x_;
  Axis y_;
  double p_place_;     // mm^2
  double p_both_ = 0;  // mm^2/s
  double p_rate_;      // mm^2/s^2
  double length_ = 0;
  double width_ = 0;
  double heading_ = 0;
  MapPoint stood_;
  double now_;  // s
  double seen_;
  double hidden_;  // when it was last seen, or its expected place was hidden
  double moved_;
  double came_;          // when it last moved
  double evidence_ = 0;  // average share of points that have moved
  double one_leg_ = 0;   // average share of scans with one leg
  double log_odds_ = 0;  // of its existence
  unsigned hits_ = 1;    // bit mask of the last scans, the newest is bit 0
  unsigned scans_ = 1;
  unsigned pairs_ = 0;                      // scans that showed two legs
  std::array<Trace, kTracesMax> traces_{};  // positions before it counts as moving, the newest last
  std::size_t traces_count_ = 0;
  double fastest_ = 0;  // mm/s, while moving
  bool person_;
  bool confirmed_ = false;
  bool moving_ = false;
  bool ever_moved_ = false;
};

}  // namespace rack::perception

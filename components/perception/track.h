// One object that is followed: where it is, how fast, how large, and what it may be. Pure.
//
// Its movement is that of a Kalman filter with constant velocity: between two scans it goes on as
// it went, with a random acceleration; north and east are alike, so that one 2 x 2 covariance does
// for both. Scanners see sides and not middles: of a box the corner that is nearest to the scanner
// is believed, and its middle lies where the largest length and width that were ever seen put it.
//
// What stands still has a speed, too, that of its noise. An object counts as moving when it is
// faster than this, has left the place where it stood, and stands where earlier scans looked
// through; and when later scans look through the places where it was. What slides along a wall
// leaves the wall there, and where many thin legs of furniture stand, which beams meet by turns,
// each place is met again. It counts as standing again when it is slow.
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

// What one scan shows of an object.
struct Sighting {
  Box box{};
  double deviation = 0;  // mm, of its centre
  double moved = 0;      // share of its points
  bool person = false;   // no larger than that
  bool leg = false;      // as narrow as one
  bool pair = false;     // two legs
  MapPoint point{};      // where a beam in its middle ended
  MapPoint scanner{};    // seen from
};

class Track {
 public:
  Track(std::int32_t id, const Sighting& sighting, double seconds);

  void predict(double seconds);
  // What the scan sees where it has been.
  void look_back(const FreeTable& now);
  // After these, one of both.
  void update(const Sighting& sighting);
  // `through`: the scan looked through where it should be.
  void miss(bool through);

  [[nodiscard]] std::int32_t id() const { return id_; }
  [[nodiscard]] MapPoint at() const { return {x_.value, y_.value}; }
  [[nodiscard]] MapPoint velocity() const { return {x_.rate, y_.rate}; }  // mm/s
  [[nodiscard]] double speed() const;
  [[nodiscard]] double deviation() const;        // mm
  [[nodiscard]] double speed_deviation() const;  // mm/s
  // Of a person: with room for a stride.
  [[nodiscard]] double length() const;
  [[nodiscard]] double width() const;
  [[nodiscard]] double heading() const { return heading_; }
  [[nodiscard]] double probability() const;
  [[nodiscard]] ObjectKind kind() const;

  [[nodiscard]] bool person() const { return person_; }
  [[nodiscard]] bool confirmed() const { return confirmed_; }
  // Confirmed, and hidden for so short a time that it is still worth to be told.
  [[nodiscard]] bool told() const;
  [[nodiscard]] bool moving() const { return moving_; }
  [[nodiscard]] bool ever_moved() const { return ever_moved_; }
  // Scans show mostly one leg of it.
  [[nodiscard]] bool one_leg() const { return one_leg_ > 0.5; }
  [[nodiscard]] bool seen_now() const { return (hits_ & 1U) != 0; }
  // It can be given up.
  [[nodiscard]] bool lost() const;
  // Something has stood there longer than this object.
  [[nodiscard]] bool is_other(const Cluster& cluster) const;
  // s since it was seen, and since it last stood where earlier scans looked through.
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
  // How many of the last scans showed it, at most 32.
  [[nodiscard]] int hits_of(unsigned scans) const;
  void learn_size(const Box& aligned);
  void judge_movement(const Sighting& sighting);
  void leave_trace(const MapPoint& point);
  [[nodiscard]] bool has_left() const;

  struct Trace {
    MapPoint at{};
    unsigned through = 0;  // scans that looked through it since
    bool met = false;      // one met something there
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
  double hidden_;  // when it was last seen, or where it should be was hidden
  double moved_;
  double came_;          // when it was last on its way
  double evidence_ = 0;  // share of points that have moved, averaged
  double one_leg_ = 0;   // share of scans, averaged
  double log_odds_ = 0;  // that it is there
  unsigned hits_ = 1;    // of the last scans, the newest lowest
  unsigned scans_ = 1;
  unsigned pairs_ = 0;                      // scans that showed two legs
  std::array<Trace, kTracesMax> traces_{};  // before it is said to move, the newest last
  std::size_t traces_count_ = 0;
  double fastest_ = 0;  // mm/s, while moving
  bool person_;
  bool confirmed_ = false;
  bool moving_ = false;
  bool ever_moved_ = false;
};

}  // namespace rack::perception

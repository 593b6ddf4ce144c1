// One object that is followed: where it is, how fast, how large, and what it may be. Pure.
//
// Its movement is that of a Kalman filter with constant velocity: between two scans it goes on as
// it went, with a random acceleration; north and east are alike, so that one 2 x 2 covariance does
// for both. Scanners see sides and not middles: of a box the corner that is nearest to the scanner
// is believed, and its middle lies where the largest length and width that were ever seen put it.
//
// What stands still has a speed, too, that of its noise. An object counts as moving when it is
// faster than this, has left the place where it stood, and stands where earlier scans looked
// through; it counts as standing again when it is slow.
#pragma once

#include <cstdint>
#include <span>

#include "components/perception/clusters.h"

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
  bool stayed = false;   // something unmoved stands where the object stood: it is that, or another
  MapPoint scanner{};    // seen from
};

class Track {
 public:
  Track(std::int32_t id, const Sighting& sighting, double seconds);

  void predict(double seconds);
  // After predict(), one of both.
  void update(const Sighting& sighting);
  void miss();

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
  [[nodiscard]] bool moving() const { return moving_; }
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

  // Where it was when it last stood.
  [[nodiscard]] const MapPoint& stood() const { return stood_; }

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
  double moved_;
  double came_;          // when it was last on its way
  double evidence_ = 0;  // share of points that have moved, averaged
  double one_leg_ = 0;   // share of scans, averaged
  double log_odds_ = 0;  // that it is there
  unsigned hits_ = 1;    // of the last scans, the newest lowest
  unsigned scans_ = 1;
  unsigned pairs_ = 0;  // scans that showed two legs
  double fastest_ = 0;  // mm/s, while moving
  bool person_;
  bool confirmed_ = false;
  bool moving_ = false;
  bool ever_moved_ = false;
};

}  // namespace rack::perception

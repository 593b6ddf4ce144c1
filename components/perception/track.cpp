#include "components/perception/track.h"

#include <algorithm>
#include <cmath>

namespace rack::perception {
namespace {

constexpr double kAcceleration = 800;  // mm/s^2, of a person that starts or turns
constexpr double kAccelerationBox = 2000;
constexpr double kFirstSpeed = 1000;   // mm/s, standard deviation
constexpr double kShrinks = 0.995;     // per scan: reduces a size that was measured too large
constexpr double kPersonLength = 800;  // mm: room for a stride
constexpr double kPersonWidth = 600;
constexpr unsigned kHistory = 32;
constexpr unsigned kConfirmOf = 5;  // scans
constexpr int kConfirm = 3;
constexpr double kPublishedFor = 0.5;  // s without being seen
constexpr double kLostAfter = 1;       // s
constexpr double kStoodLostAfter = 5;  // s, if it stood
constexpr double kGoneAfter = 0.45;    // s, if scans see through its expected place
constexpr double kGivenUpAfter = 0.5;  // s, if not confirmed

constexpr double kMovesFrom = 250;    // mm/s
constexpr double kMovesUntil = 120;   // mm/s
constexpr double kMovesSurely = 2.5;  // standard deviations
constexpr double kLeft = 500;         // mm from where it stood
constexpr double kLeftSurely = 1500;  // mm
constexpr double kEvidence = 0.6;     // share of points that have moved
constexpr int kHitsToMove = 7;        // number of sightings before it can count as moving
constexpr double kEvidenceGain = 0.2;
constexpr double kJustCome = 1.5;  // s: before that, another object may have stood there

constexpr double kOddsHit = 0.7;
constexpr double kOddsMiss = 0.4;
constexpr double kOddsMost = 4;

constexpr double kBike = 3000;       // mm/s: people run slower than they cycle
constexpr double kBikeWidth = 1000;  // mm
constexpr double kBig = 1000;
constexpr double kCarLength = 2000;
constexpr double kTruckLength = 6500;

constexpr double kTracesApart = 250;  // mm
constexpr double kGone = 400;         // mm: the object has left the trace
constexpr double kTraceHalf = 60;     // mm, half a leg
constexpr int kThroughLeast = 2;      // scans
constexpr int kLeftLeast = 2;         // traces

double square(double value) { return value * value; }

}  // namespace

Track::Track(std::int32_t id, const Sighting& sighting, double seconds)
    : id_(id),
      x_{.value = sighting.box.centre.x},
      y_{.value = sighting.box.centre.y},
      p_place_(square(sighting.deviation)),
      p_rate_(square(kFirstSpeed)),
      heading_(sighting.box.heading),
      stood_(sighting.box.centre),
      now_(seconds),
      seen_(seconds),
      hidden_(seconds),
      moved_(seconds),
      came_(seconds),
      evidence_(sighting.moved),
      pairs_(sighting.pair ? 1 : 0),
      person_(sighting.person) {
  learn_size(sighting.box);
  leave_trace(sighting.point);
}

void Track::predict(double seconds) {
  const double dt = std::max(seconds - now_, 0.0);
  now_ = seconds;
  x_.value += x_.rate * dt;
  y_.value += y_.rate * dt;
  const double q = square(person_ ? kAcceleration : kAccelerationBox) * dt;  // (mm/s)^2 per second
  p_place_ += 2 * dt * p_both_ + dt * dt * p_rate_ + q * dt * dt / 3;
  p_both_ += dt * p_rate_ + q * dt / 2;
  p_rate_ += q;
}

void Track::correct(const MapPoint& measured, double deviation) {
  const double innovation = p_place_ + square(deviation);
  const double gain = p_place_ / innovation;
  const double gain_rate = p_both_ / innovation;
  const double dx = measured.x - x_.value;
  const double dy = measured.y - y_.value;
  x_.value += gain * dx;
  y_.value += gain * dy;
  x_.rate += gain_rate * dx;
  y_.rate += gain_rate * dy;
  p_rate_ -= gain_rate * p_both_;
  p_both_ *= 1 - gain;
  p_place_ *= 1 - gain;
}

void Track::update(const Sighting& sighting) {
  hits_ = hits_ << 1U | 1U;
  ++scans_;
  seen_ = now_;
  hidden_ = now_;
  person_ = sighting.person;
  if (sighting.pair) ++pairs_;
  one_leg_ += kEvidenceGain * ((sighting.leg && !sighting.pair ? 1 : 0) - one_leg_);
  const Box aligned = person_ ? sighting.box : align(sighting.box);
  learn_size(aligned);
  correct(person_ ? aligned.centre : centre_of(aligned, sighting.scanner), sighting.deviation);
  if (!person_) heading_ = aligned.heading;
  confirmed_ = confirmed_ || hits_of(kConfirmOf) >= kConfirm;
  log_odds_ = std::min(log_odds_ + kOddsHit, kOddsMost);
  leave_trace(sighting.point);
  judge_movement(sighting);
}

int Track::hits_of(unsigned scans) const {
  int count = 0;
  for (unsigned i = 0; i < scans; ++i) count += static_cast<int>(hits_ >> i & 1U);
  return count;
}

void Track::miss(bool through) {
  if (!through) hidden_ = now_;
  hits_ <<= 1U;
  ++scans_;
  log_odds_ = std::max(log_odds_ - kOddsMiss, -kOddsMost);
}

// The same rectangle, with its length along the side that is nearest to the last heading.
Box Track::align(const Box& box) const {
  const double quarter = kPi / 2;
  const double turn = signed_angle(heading_ - box.heading);
  const auto quarters = static_cast<int>(std::lround(turn / quarter));
  Box aligned = box;
  aligned.heading = rack::heading(box.heading + quarters * quarter);
  if (quarters % 2 != 0) std::swap(aligned.length, aligned.width);
  return aligned;
}

MapPoint Track::centre_of(const Box& aligned, const MapPoint& scanner) const {
  const double c = std::cos(aligned.heading);
  const double s = std::sin(aligned.heading);
  const double dx = aligned.centre.x - scanner.x;
  const double dy = aligned.centre.y - scanner.y;
  // Shifts the centre away from the scanner along each axis, by half of the unseen part.
  const double along = std::copysign((length_ - aligned.length) / 2, dx * c + dy * s);
  const double across = std::copysign((width_ - aligned.width) / 2, dy * c - dx * s);
  return {aligned.centre.x + along * c - across * s, aligned.centre.y + along * s + across * c};
}

void Track::learn_size(const Box& aligned) {
  length_ = std::max(length_ * kShrinks, aligned.length);
  width_ = std::max(width_ * kShrinks, aligned.width);
}

void Track::leave_trace(const MapPoint& point) {
  if (ever_moved_) return;
  if (traces_count_ > 0) {
    const MapPoint& last = traces_[traces_count_ - 1].at;
    if (std::hypot(point.x - last.x, point.y - last.y) < kTracesApart) return;
  }
  if (traces_count_ == kTracesMax) {
    std::shift_left(traces_.begin(), traces_.end(), 1);
    --traces_count_;
  }
  traces_[traces_count_++] = {.at = point};
}

void Track::look_back(const FreeTable& now) {
  if (ever_moved_) return;
  for (Trace& trace : std::span(traces_).first(traces_count_)) {
    if (std::hypot(trace.at.x - x_.value, trace.at.y - y_.value) < kGone) continue;
    const auto seen = now.look(trace.at, kTraceHalf);
    if (seen == FreeTable::Seen::kThrough) ++trace.through;
    if (seen == FreeTable::Seen::kMet) trace.met = true;
  }
}

// One hit is enough: something that flickers is seen through by the next scan.
bool Track::has_left() const {
  if (traces_count_ > 0 && traces_.front().met) return false;
  int left = 0;
  int kept = 0;
  for (const Trace& trace : std::span(traces_).first(traces_count_)) {
    if (trace.met)
      ++kept;
    else if (trace.through >= kThroughLeast)
      ++left;
  }
  return left >= kLeftLeast && left > 2 * kept;
}

void Track::judge_movement(const Sighting& sighting) {
  evidence_ += kEvidenceGain * (sighting.moved - evidence_);
  if (sighting.moved > kEvidence) moved_ = now_;
  const double fast = speed();
  if (moving_ && fast < kMovesUntil) {
    moving_ = false;
    stood_ = at();
  }
  // An object that has moved before needs less evidence.
  const double left = std::hypot(x_.value - stood_.x, y_.value - stood_.y);
  const bool surely = left > kLeftSurely || fast > kMovesSurely * speed_deviation();
  const bool can = ever_moved_ || (left > kLeft && surely && has_left() && evidence_ > kEvidence &&
                                   hits_of(kHistory) >= kHitsToMove);
  if (!moving_ && confirmed_ && can && fast > kMovesFrom) moving_ = true;
  if (!moving_) return;
  ever_moved_ = true;
  came_ = now_;
  fastest_ = std::max(fastest_, fast);
  if (person_) heading_ = rack::heading(std::atan2(y_.rate, x_.rate));
}

double Track::length() const { return person_ ? std::max(length_, kPersonLength) : length_; }
double Track::width() const { return person_ ? std::max(width_, kPersonWidth) : width_; }
double Track::speed() const { return std::hypot(x_.rate, y_.rate); }
double Track::deviation() const { return std::sqrt(p_place_); }
double Track::speed_deviation() const { return std::sqrt(p_rate_); }
double Track::probability() const { return 1 / (1 + std::exp(-log_odds_)); }

bool Track::is_other(const Cluster& cluster) const {
  return cluster.stood > now_ - came_ + kJustCome;
}

bool Track::published() const { return confirmed_ && unseen() <= kPublishedFor; }

bool Track::lost() const {
  if (confirmed_) {
    const bool stood = ever_moved_ && !moving_;
    return unseen() > (stood ? kStoodLostAfter : kLostAfter) || now_ - hidden_ > kGoneAfter;
  }
  return unseen() > kGivenUpAfter || (scans_ >= kConfirmOf && !seen_now());
}

double Track::mahalanobis(const Cluster& cluster, double deviation) const {
  const double dx = cluster.box.centre.x - x_.value;
  const double dy = cluster.box.centre.y - y_.value;
  return (dx * dx + dy * dy) / (p_place_ + square(deviation));
}

ObjectKind Track::kind() const {
  if (!confirmed_) return ObjectKind::kUnclassified;
  const double longer = std::max(length_, width_);
  const double narrower = std::min(length_, width_);
  if (ever_moved_) {
    if (fastest_ > kBike && narrower < kBikeWidth && longer < kCarLength) return ObjectKind::kBike;
    if (person_) return ObjectKind::kPedestrian;
    if (longer > kTruckLength) return ObjectKind::kTruck;
    if (longer > kCarLength) return ObjectKind::kCar;
  }
  if (person_ && pairs_ * 2 > scans_) return ObjectKind::kPedestrian;
  return longer > kBig ? ObjectKind::kBig : ObjectKind::kSmall;
}

}  // namespace rack::perception

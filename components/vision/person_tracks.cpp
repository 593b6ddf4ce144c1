#include "components/vision/person_tracks.h"

#include <algorithm>
#include <limits>

#include <Eigen/LU>

namespace rack::vision {

namespace {

constexpr double kGate = 9.21;           // 99 % of the sightings of a track are within, chi-squared
constexpr double kWalkDeviation = 1000;  // mm/s, of people whose speed is not known
constexpr double kAcceleration = 1000;   // mm/s^2, standard deviation
constexpr double kMemory = 0.5;          // of the probability, per sighting

using Observation = Eigen::Matrix<double, 2, 4>;

}  // namespace

PersonTrack::PersonTrack(i32 id, const PersonSighting& sighting, std::size_t index, double time)
    : id_(id), probability_(sighting.probability), seen_(time), sighting_(index) {
  state_.head<2>() = sighting.at;
  covariance_.topLeftCorner<2, 2>() = sighting.covariance;
  covariance_.bottomRightCorner<2, 2>() =
      Eigen::Matrix2d::Identity() * kWalkDeviation * kWalkDeviation;
}

double PersonTrack::probability(double time) const {
  const double unseen = (time - seen_) / PersonTracks::kUnseenMax;
  return probability_ * std::clamp(1 - unseen, 0.0, 1.0);
}

void PersonTrack::predict(double seconds) {
  Eigen::Matrix4d step = Eigen::Matrix4d::Identity();
  step.topRightCorner<2, 2>() = Eigen::Matrix2d::Identity() * seconds;
  // What a constant acceleration changes in this time.
  Eigen::Matrix<double, 4, 2> pushed;
  pushed << Eigen::Matrix2d::Identity() * seconds * seconds / 2,
      Eigen::Matrix2d::Identity() * seconds;
  state_ = (step * state_).eval();
  covariance_ = (step * covariance_ * step.transpose()).eval();
  covariance_ += kAcceleration * kAcceleration * pushed * pushed.transpose();
  sighting_.reset();
}

double PersonTrack::distance(const PersonSighting& sighting) const {
  const Eigen::Vector2d off = sighting.at - at();
  const Eigen::Matrix2d sum = covariance() + sighting.covariance;
  return off.dot(sum.inverse() * off);
}

void PersonTrack::take(const PersonSighting& sighting, std::size_t index, double time) {
  const Observation seen = Observation::Identity();
  const Eigen::Matrix2d sum = covariance() + sighting.covariance;
  const Eigen::Matrix<double, 4, 2> gain = covariance_ * seen.transpose() * sum.inverse();
  state_ += (gain * (sighting.at - at())).eval();
  const Eigen::Matrix4d rest = Eigen::Matrix4d::Identity() - gain * seen;
  // Joseph's form stays symmetric and positive.
  covariance_ =
      (rest * covariance_ * rest.transpose() + gain * sighting.covariance * gain.transpose())
          .eval();
  probability_ += (1 - kMemory) * (sighting.probability - probability_);
  seen_ = time;
  is_confirmed_ = true;
  sighting_ = index;
}

void PersonTracks::forget() {
  tracks_.clear();
  time_.reset();
}

void PersonTracks::take(std::span<const PersonSighting> sightings, double time) {
  if (time_ && time == *time_) return;
  if (time_ && time < *time_) forget();
  // A pause in which all tracks end needs no prediction.
  const double passed = time_ ? time - *time_ : 0;
  time_ = time;
  std::erase_if(tracks_,
                [&](const PersonTrack& track) { return time - track.last_seen() > kUnseenMax; });
  for (PersonTrack& track : tracks_) track.predict(passed);
  match(sightings, time);
}

void PersonTracks::match(std::span<const PersonSighting> sightings, double time) {
  struct Pair {
    double distance;
    std::size_t track;
    std::size_t sighting;
  };
  const auto is_usable = [](const PersonSighting& sighting) {
    return sighting.at.allFinite() && sighting.covariance.allFinite() &&
           sighting.covariance.determinant() > 0;
  };
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    for (std::size_t k = 0; k < sightings.size(); ++k) {
      if (!is_usable(sightings[k])) continue;
      const double distance = tracks_[i].distance(sightings[k]);
      if (distance <= kGate) pairs.push_back({distance, i, k});
    }
  std::ranges::sort(pairs, {}, &Pair::distance);
  std::vector<bool> is_taken(sightings.size(), false);
  for (const Pair& pair : pairs) {
    if (is_taken[pair.sighting] || tracks_[pair.track].sighting()) continue;
    tracks_[pair.track].take(sightings[pair.sighting], pair.sighting, time);
    is_taken[pair.sighting] = true;
  }
  for (std::size_t k = 0; k < sightings.size() && tracks_.size() < kTracksMax; ++k) {
    if (is_taken[k] || !is_usable(sightings[k])) continue;
    tracks_.emplace_back(next_id_, sightings[k], k, time);
    next_id_ = next_id_ == std::numeric_limits<i32>::max() ? 1 : next_id_ + 1;
  }
}

}  // namespace rack::vision

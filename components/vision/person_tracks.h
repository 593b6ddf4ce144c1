// Follows people over pictures: which of those in this picture is which of the one before, and how
// fast each moves.
//
// Each person has a Kalman filter of place and velocity. A picture predicts all of them, and each
// sighting goes to the track it fits best, nearest pairs first, within a gate that follows from the
// uncertainty of both. What fits none begins a track, which is not reported before it was seen a
// second time; a track that was not seen for a second ends. Pure.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "rack/codec/quantity.h"

namespace rack::vision {

// In a frame that stands still: that of the position, mm.
struct PersonSighting {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
  double probability = 0;
};

class PersonTrack {
 public:
  PersonTrack(i32 id, const PersonSighting& sighting, std::size_t index, double time);

  [[nodiscard]] i32 id() const { return id_; }
  [[nodiscard]] Eigen::Vector2d at() const { return state_.head<2>(); }
  [[nodiscard]] Eigen::Vector2d velocity() const { return state_.tail<2>(); }  // mm/s
  [[nodiscard]] Eigen::Matrix2d covariance() const { return covariance_.topLeftCorner<2, 2>(); }
  [[nodiscard]] Eigen::Matrix2d velocity_covariance() const {
    return covariance_.bottomRightCorner<2, 2>();
  }
  // That it exists. Lower from picture to picture without a sighting.
  [[nodiscard]] double probability(double time) const;
  [[nodiscard]] bool is_confirmed() const { return is_confirmed_; }
  // The index of its sighting in the last picture.
  [[nodiscard]] std::optional<std::size_t> sighting() const { return sighting_; }
  [[nodiscard]] double last_seen() const { return seen_; }

  void predict(double seconds);
  // Square of the distance in standard deviations.
  [[nodiscard]] double distance(const PersonSighting& sighting) const;
  void take(const PersonSighting& sighting, std::size_t index, double time);

 private:
  i32 id_;
  Eigen::Vector4d state_ = Eigen::Vector4d::Zero();  // x, y, their speeds
  Eigen::Matrix4d covariance_ = Eigen::Matrix4d::Zero();
  double probability_;
  double seen_;  // s
  bool is_confirmed_ = false;
  std::optional<std::size_t> sighting_;
};

class PersonTracks {
 public:
  static constexpr std::size_t kTracksMax = 100;
  static constexpr double kUnseenMax = 1;  // s

  // `time`: of the picture, s. If it is before that of the last one, all tracks are forgotten; the
  // second of two pictures of the same time is ignored, as are sightings that are not numbers.
  void take(std::span<const PersonSighting> sightings, double time);
  // Begins again; numbers go on.
  void forget();

  [[nodiscard]] const std::vector<PersonTrack>& tracks() const { return tracks_; }

 private:
  void match(std::span<const PersonSighting> sightings, double time);

  std::vector<PersonTrack> tracks_;
  std::optional<double> time_;
  i32 next_id_ = 1;
};

}  // namespace rack::vision

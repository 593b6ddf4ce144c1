// Monte Carlo localisation: the pose of a robot in a map, estimated by a particle filter (Dellaert,
// Fox, Burgard, Thrun 1999; Probabilistic Robotics, chapter 8). Pure.
//
// Each particle is a pose. Odometry moves all particles, each with its own noise; a scan gives each
// particle a weight by how well the scan fits the map from that pose. Resampling drops particles of
// little weight and duplicates the others, so that the cloud covers the poses that the robot can
// have. The details:
// - Noise is split: wheels slip when they turn, so that the heading is much less certain than the
//   distance. A tenth of the particles assumes far worse odometry, for the times when it is.
// - Weights are flat: the errors of neighbouring beams are correlated, so a scan counts as a few
//   beams only.
// - Resampling is systematic (one random number), and happens only when the effective number of
//   particles is less than half of all.
// - The number of particles follows from the spread of the cloud (KLD sampling, Fox 2003): as many
//   as it takes to represent the bins of space that it occupies.
// - When scans fit worse than their long-term average, the robot may have been carried away
//   (augmented MCL: a slow and a fast average). Then a part of the cloud is replaced by new
//   particles at places of the map where the scan fits.
// - When a single scan does not fit, the odometry has jumped: then a part of the cloud is replaced
//   by new particles near it, at places where the scan fits, before the robot is lost.
//
// Structure of arrays: each field of all particles is one contiguous array of float; sine and
// cosine of each heading are computed once. The constructor allocates all memory.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "components/geometry/pose.h"
#include "components/geometry/random.h"
#include "components/localisation/likelihood_field.h"

namespace rack::localisation {

struct FilterSettings {
  std::uint32_t particles = 500;        // while the robot is localised
  std::uint32_t particles_max = 20000;  // while the filter searches
  // Standard deviations of the odometry.
  double turn_by_turn = 0.15;      // rad for each rad
  double turn_by_distance = 0.05;  // rad for each m
  double along_by_distance = 0.1;  // mm for each mm, along
  double side_by_distance = 0.02;  // mm for each mm, across
  double turn_least = 0.003;       // rad, minimum of a step
  double distance_least = 8;       // mm, minimum of a step
  double slip_share = 0.1;         // of the particles, which assume that wheels slip
  double slip_times = 4;           // factor of their noise
  // A scan that fits wholly is exp(sharpness) times as likely as one that does not fit at all.
  double sharpness = 15;
  double kld_error = 0.05;
  double kld_quantile = 2.33;  // of the normal distribution: 99 %
  // Rates of the slow and the fast average of the fit of scans. Recovery begins when the fast one
  // times the margin is below the slow one.
  double average_slow = 0.003;
  double average_fast = 0.15;
  double recovery_margin = 1.15;
  // A single scan that is below the slow average by this factor starts a search nearby: uniformly
  // within these distances.
  double jump_margin = 1.1;
  double jump_distance = 1000;  // mm
  double jump_turn = 0.6;       // rad
};

// Standard deviations of a step: mm, rad.
struct StepNoise {
  double along = 0;
  double across = 0;
  double turn = 0;
};
StepNoise noise_of(const FilterSettings& settings, double distance, double turn);

// Symmetric, in mm and rad.
struct Covariance {
  double xx = 0;
  double xy = 0;
  double yy = 0;
  double x_rho = 0;
  double y_rho = 0;
  double rho_rho = 0;
};

struct Estimate {
  Pose pose{};
  Covariance covariance{};
  double share = 0;  // of the whole weight: 1 when the cloud is in one place
};

// A histogram of the weight over poses; bins of half a metre and 15 degrees.
class PoseBins {
 public:
  explicit PoseBins(std::size_t poses_max);

  void clear();
  void add(float x, float y, float rho, float weight);
  [[nodiscard]] std::size_t count() const { return count_; }
  // The mean of the heaviest bin and its neighbours of the same heading.
  struct Heaviest {
    Pose middle{};
    float weight = 0;
  };
  [[nodiscard]] Heaviest heaviest() const;

 private:
  struct Bin {
    std::uint32_t stamp = 0;
    float weight = 0;
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t rho = 0;
  };
  [[nodiscard]] std::size_t place(std::int32_t x, std::int32_t y, std::int32_t rho) const;
  [[nodiscard]] float weight(std::int32_t x, std::int32_t y, std::int32_t rho) const;

  std::vector<Bin> bins_;
  std::vector<std::uint32_t> used_;
  std::uint32_t stamp_ = 1;
  std::size_t count_ = 0;
};

class ParticleFilter {
 public:
  ParticleFilter(const FilterSettings& settings, std::uint64_t seed);

  void start_at(const Pose& pose, double deviation, double deviation_rho);
  // Everywhere in free space, denser where the scan fits.
  void start_anywhere(const LikelihoodField& field, const Beams& beams);

  // A step in the frame of the robot.
  void move(const Pose& step);
  void weigh(const LikelihoodField& field, const Beams& beams);
  // Particles near `pose` get at least this share of the weight, if there are any.
  void favour(const Pose& pose, double share);
  // Where particles may be drawn from that replace a part of the cloud, when scans do not fit.
  struct Search {
    bool anywhere = true;  // the whole map
    bool nearby = true;    // around particles
    double least = 0;      // share of the cloud to draw anywhere, whatever the average fits
  };
  // After weigh() and estimate(): draws the cloud for the next step.
  void resample(const LikelihoodField& field, const Beams& beams, const Search& search);

  // Mean and covariance of the heaviest part of the cloud.
  [[nodiscard]] Estimate estimate();
  // Mean and covariance of the part of the cloud near `expected`, whatever its weight.
  [[nodiscard]] Estimate estimate_near(const Pose& expected) const;

  [[nodiscard]] std::size_t size() const { return x_.size(); }
  [[nodiscard]] Pose particle(std::size_t i) const {
    return {.x = x_[i], .y = y_[i], .rho = rho_[i]};
  }
  // Whether a scan with this fit means that the robot is not where the cloud is.
  [[nodiscard]] bool misfits(double fit) const { return fit * settings_.jump_margin < slow_; }
  // The share of the cloud that recovery replaces, 0 to 1; above 0 when scans fit worse than their
  // long-term average.
  [[nodiscard]] double searching_share() const;
  // The average fit of the last scan given to weigh(), 0 to 1.
  [[nodiscard]] double fit() const { return fit_; }
  // The number of particles that the last resample() replaced by new ones.
  [[nodiscard]] std::size_t injected() const { return injected_; }

 private:
  struct Cloud {
    std::vector<float> x, y, rho, sine, cosine;
  };
  void set(std::size_t i, float x, float y, float rho);
  struct Draw {
    float x, y, rho;
  };
  // Adds the draw that fits best out of `tries`.
  template <typename Source>
  void add_fitting(const LikelihoodField& field, const Beams& beams, std::uint32_t tries,
                   const Source& source);
  [[nodiscard]] Draw anywhere(const LikelihoodField& field);
  [[nodiscard]] Draw near(std::size_t particle);
  void add(float x, float y, float rho);
  void even_weights();
  void clear();
  [[nodiscard]] std::size_t wanted_size() const;
  [[nodiscard]] Estimate around(const Pose& middle) const;
  void draw_systematically(std::size_t count);

  FilterSettings settings_;
  Random random_;
  std::vector<float> x_, y_, rho_, sine_, cosine_, weight_;
  Cloud next_;
  PoseBins bins_;
  double effective_ = 0;  // number of particles that carry the weight
  double fit_ = 0;
  double slow_ = 0;
  double fast_ = 0;
  std::size_t injected_ = 0;
};

}  // namespace rack::localisation

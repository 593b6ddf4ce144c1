// Where a robot is in a map, as a cloud of guesses (Monte Carlo localisation: Dellaert, Fox,
// Burgard, Thrun 1999; Probabilistic Robotics, chapter 8). Pure.
//
// Each particle is a pose. When the robot moves, all move as the odometry says, each with some
// noise of its own; when it scans, each gets a weight by how well the scan would fit the map from
// there. Particles with little weight die and others multiply, so that the cloud stays where the
// robot can be. What makes it good:
// - Noise is split: turning wheels slip when they turn, so that the heading is much less certain
//   than the way. A tenth of the particles believes in far worse odometry, for when it is.
// - Weights are flat: neighbouring beams err together, so a scan counts as a few beams only.
// - Resampling is systematic (one random number), and only when half of the cloud is idle.
// - The number of particles follows from how far the cloud is spread (KLD sampling, Fox 2003): as
//   many as it takes to represent the bins of space that it is in.
// - When scans fit worse than they did for long, the robot may have been carried away (augmented
//   MCL: two averages, a slow and a fast one). Then a part of the cloud is drawn anew, from places
//   of the map where the scan fits.
// - When a single scan does not fit, the odometry has jumped: then a part is drawn from places near
//   the cloud where it fits, before the robot is lost.
//
// Numbers lie in arrays a field, of floats; the sine and cosine of a heading are computed once.
// All memory is taken by the constructor.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "components/geometry/pose.h"
#include "components/geometry/random.h"
#include "components/localisation/likelihood_field.h"

namespace rack::localisation {

struct FilterSettings {
  std::uint32_t particles = 500;        // while it knows where it is
  std::uint32_t particles_max = 20000;  // while it searches
  // Standard deviations of what the odometry says.
  double turn_by_turn = 0.15;  // rad for each rad
  double turn_by_way = 0.05;   // rad for each m
  double way_by_way = 0.1;     // mm for each mm, along
  double side_by_way = 0.02;   // and across
  double turn_least = 0.003;   // rad in each step
  double way_least = 8;        // mm in each step
  double slip_share = 0.1;     // of the particles, whose noise is
  double slip_times = 4;       // so many times larger
  // How much likelier a scan that fits wholly is than one that does not at all: exp(this).
  double sharpness = 15;
  double kld_error = 0.05;
  double kld_quantile = 2.33;  // of the normal distribution: 99 %
  // Averages of how scans fit, and how much the fast one must be below the slow one.
  double average_slow = 0.003;
  double average_fast = 0.15;
  double recovery_margin = 1.15;
  // And a single scan, for a search nearby: so far, uniformly.
  double jump_margin = 1.1;
  double jump_way = 1000;  // mm
  double jump_turn = 0.6;  // rad
};

// Standard deviations of a step: mm, rad.
struct StepNoise {
  double along = 0;
  double across = 0;
  double turn = 0;
};
StepNoise noise_of(const FilterSettings& settings, double way, double turn);

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

// How much weight lies in which part of space: half a metre, 15 degrees.
class PoseBins {
 public:
  explicit PoseBins(std::size_t poses_max);

  void clear();
  void add(float x, float y, float rho, float weight);
  [[nodiscard]] std::size_t count() const { return count_; }
  // The middle of the heaviest bin with its neighbours of the same heading.
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
  // Everywhere that is free, more where the scan fits.
  void start_anywhere(const LikelihoodField& field, const Beams& beams);

  // A step in the frame of the robot.
  void move(const Pose& step);
  void weigh(const LikelihoodField& field, const Beams& beams);
  // What is near `pose` gets at least so much of the weight, if anything is there.
  void favour(const Pose& pose, double share);
  // After weigh() and estimate(): the cloud for the next step. `searches`: a part of it may be
  // drawn anew from anywhere.
  void resample(const LikelihoodField& field, const Beams& beams, bool searches);

  // Mean and covariance of the heaviest part of the cloud.
  [[nodiscard]] Estimate estimate();
  // And of the part that is near `expected`, however heavy.
  [[nodiscard]] Estimate estimate_near(const Pose& expected) const;

  [[nodiscard]] std::size_t size() const { return x_.size(); }
  [[nodiscard]] Pose particle(std::size_t i) const {
    return {.x = x_[i], .y = y_[i], .rho = rho_[i]};
  }
  // Whether a scan that fits so well means that the robot is not where the cloud is.
  [[nodiscard]] bool misfits(double fit) const { return fit * settings_.jump_margin < slow_; }
  // The part of the cloud that is to be drawn anew, as scans fit worse than they did for long.
  [[nodiscard]] double searching_share() const;
  // Of the last weigh(): how well the scan fits on average, 0 to 1.
  [[nodiscard]] double fit() const { return fit_; }
  // Of the last resample(): how many particles were drawn anew.
  [[nodiscard]] std::size_t injected() const { return injected_; }

 private:
  struct Cloud {
    std::vector<float> x, y, rho, sine, cosine;
  };
  void set(std::size_t i, float x, float y, float rho);
  struct Draw {
    float x, y, rho;
  };
  // The best of so many draws.
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

// The particle filter of MRPT (CMonteCarloLocalization2D) in place of our localiser: converts our
// map to its grid, odometry to its actions, beams to its scans, and its result back.
//
// MRPT's axes are right-handed: its y is our -y, and its angles have the opposite sign. The origin
// of its frame is the corner of the map, because its grid can only start at a multiple of the
// resolution. It gets complete scans when ours does, after 0.1 m or 0.1 rad, and uses every n-th
// point.
#pragma once

#include <memory>

#include "components/localisation/grid_map.h"
#include "tools/evaluation/mcl_eval/evaluation.h"

namespace rack::mcl_eval {

// Lengths in m, angles in rad, as in MRPT. Their meaning and how they were chosen:
// components/localisation/README.md.
struct MrptSettings {
  unsigned particles = 500;
  unsigned beams = 60;
  double distance_between = 0.1;
  double turn_between = 0.1;
  // TMotionModelOptions::gaussianModel
  double a1 = 0.2;   // m/m
  double a2 = 0;     // m/rad
  double a3 = 0.15;  // rad/m
  double a4 = 0.15;  // rad/rad
  double min_std_xy = 0.015;
  double min_std_phi = 0.01;
  // TLikelihoodOptions
  double std_hit = 0.1;
  double max_distance = 0.5;  // LF_maxCorrsDistance
  double z_hit = 0.95;
  double max_range = 81;
  // TParticleFilterOptions
  double power = 0.25;  // powFactor
  double beta = 0.5;
  bool optimal = false;  // pfAuxiliaryPFOptimal
};

class MrptFilter final : public Contestant {
 public:
  MrptFilter(const MrptSettings& settings, const localisation::GridMap& map, std::uint64_t seed);
  ~MrptFilter() override;

  void start_at(const Pose& pose, double deviation, double deviation_rho) override;
  void start_anywhere() override;
  bool take(const Pose& odometry, const localisation::LogScan& scan,
            std::span<const localisation::BeamEnd> beams) override;
  [[nodiscard]] Pose pose() const override;
  [[nodiscard]] double share() const override { return 1; }
  [[nodiscard]] bool searches() const override { return false; }

  // The logarithm of the likelihood of the complete scan at that pose.
  [[nodiscard]] double likelihood(const Pose& robot, const localisation::LogScan& scan,
                                  std::span<const localisation::BeamEnd> beams) const;

 private:
  struct Parts;  // objects of MRPT
  std::unique_ptr<Parts> parts_;
};

}  // namespace rack::mcl_eval

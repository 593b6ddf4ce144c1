#include "tests/bench/mrpt/mrpt_filter.h"

#include <cmath>

#include <mrpt/bayes/CParticleFilter.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/random.h>
#include <mrpt/slam/CMonteCarloLocalization2D.h>

namespace rack::mcl_eval {

using localisation::BeamEnd;
using localisation::Cell;
using localisation::GridMap;
using localisation::LogScan;
using mrpt::bayes::CParticleFilter;
using mrpt::maps::COccupancyGridMap2D;
using mrpt::obs::CActionCollection;
using mrpt::obs::CActionRobotMovement2D;
using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CSensoryFrame;
using mrpt::poses::CPose2D;
using mrpt::poses::CPose3D;

namespace {

constexpr float kOccupied = 0.02F;  // probability of being free
constexpr float kFree = 0.98F;
constexpr float kUnknown = 0.5F;

// Converts a step or a pose on the robot; poses in the map frame are shifted as well.
CPose2D mirrored(const Pose& pose) { return {pose.x / 1000, -pose.y / 1000, -pose.rho}; }

COccupancyGridMap2D::Ptr grid_of(const GridMap& map, const MrptSettings& settings) {
  const auto resolution = static_cast<float>(map.resolution / 1000);
  auto grid = COccupancyGridMap2D::Create();
  grid->setSize(0, resolution * static_cast<float>(map.rows), 0,
                resolution * static_cast<float>(map.columns), resolution, kUnknown);
  for (std::int32_t row = 0; row < map.rows; ++row)
    for (std::int32_t column = 0; column < map.columns; ++column) {
      const Cell cell = map.at(row, column);
      if (cell != Cell::kUnknown)
        grid->setCell(row, map.columns - 1 - column, cell == Cell::kFree ? kFree : kOccupied);
    }
  auto& options = grid->likelihoodOptions;
  options.likelihoodMethod = COccupancyGridMap2D::lmLikelihoodField_Thrun;
  options.LF_stdHit = static_cast<float>(settings.std_hit);
  options.LF_zHit = static_cast<float>(settings.z_hit);
  options.LF_zRandom = static_cast<float>(1 - settings.z_hit);
  options.LF_maxRange = static_cast<float>(settings.max_range);
  options.LF_maxCorrsDistance = static_cast<float>(settings.max_distance);
  options.LF_decimation = 1;
  return grid;
}

}  // namespace

struct MrptFilter::Parts {
  Parts(const MrptSettings& wanted, const GridMap& map, std::uint64_t seed)
      : settings(wanted),
        corner{.x = map.origin.x, .y = map.origin.y + map.columns * map.resolution},
        grid(grid_of(map, wanted)) {
    cloud.options.metricMap = grid;
    cloud.m_particles.resize(wanted.particles);
    auto& options = filter.m_options;
    options.PF_algorithm = wanted.optimal ? CParticleFilter::pfAuxiliaryPFOptimal
                                          : CParticleFilter::pfStandardProposal;
    options.resamplingMethod = CParticleFilter::prSystematic;
    options.adaptiveSampleSize = false;
    options.sampleSize = wanted.particles;
    options.BETA = wanted.beta;
    options.powFactor = wanted.power;
    options.pfAuxFilterOptimal_MaximumSearchSamples = 10;
    motion.modelSelection = CActionRobotMovement2D::mmGaussian;
    motion.gaussianModel = {wanted.a1, wanted.a2,         wanted.a3,
                            wanted.a4, wanted.min_std_xy, wanted.min_std_phi};
    mrpt::random::getRandomGenerator().randomize(static_cast<std::uint32_t>(seed));
  }

  [[nodiscard]] CPose2D from_rack(const Pose& pose) const {
    return mirrored({.x = pose.x - corner.x, .y = pose.y - corner.y, .rho = pose.rho});
  }
  [[nodiscard]] Pose to_rack(const CPose2D& pose) const {
    return {.x = pose.x() * 1000 + corner.x, .y = corner.y - pose.y() * 1000, .rho = -pose.phi()};
  }
  [[nodiscard]] CObservation2DRangeScan::Ptr scan_of(const LogScan& scan,
                                                     std::span<const BeamEnd> beams) const {
    auto made = CObservation2DRangeScan::Create();
    made->resizeScanAndAssign(scan.count, 0, false);
    const double aperture = scan.step * static_cast<double>(scan.count - 1);
    Pose middle = scan.laser;
    middle.rho += scan.first + aperture / 2;
    made->sensorPose = CPose3D(mirrored(middle));
    made->aperture = static_cast<float>(std::abs(aperture));
    made->rightToLeft = scan.step < 0;
    made->maxRange = static_cast<float>(settings.max_range);
    for (const BeamEnd& beam : beams) {
      const double x = static_cast<double>(beam.x) - scan.laser.x;
      const double y = static_cast<double>(beam.y) - scan.laser.y;
      const double angle = std::atan2(y, x) - scan.laser.rho - scan.first;
      const double step = std::abs(scan.step);
      const auto i =
          static_cast<std::size_t>(heading((scan.step < 0 ? -angle : angle) + step / 2) / step);
      if (i >= scan.count) continue;
      made->setScanRange(i, static_cast<float>(std::hypot(x, y) / 1000));
      made->setScanRangeValidity(i, true);
    }
    return made;
  }

  void step(const Pose& moved, const CObservation2DRangeScan::Ptr& scan) {
    CActionRobotMovement2D movement;
    movement.computeFromOdometry(mirrored(moved), motion);
    CActionCollection actions;
    actions.insert(movement);
    CSensoryFrame frame;
    frame.insert(scan);
    filter.executeOn(cloud, &actions, &frame);
    CPose2D mean;
    cloud.getMean(mean);
    estimate = to_rack(mean);
  }

  MrptSettings settings;
  Pose corner;
  COccupancyGridMap2D::Ptr grid;
  mrpt::slam::CMonteCarloLocalization2D cloud;
  CParticleFilter filter;
  CActionRobotMovement2D::TMotionModelOptions motion;
  Pose estimate{};
  Pose odometry{};  // the newest
  Pose taken{};     // odometry of the last scan used
  bool fresh = true;
};

MrptFilter::MrptFilter(const MrptSettings& settings, const GridMap& map, std::uint64_t seed)
    : parts_(std::make_unique<Parts>(settings, map, seed)) {}
MrptFilter::~MrptFilter() = default;

void MrptFilter::start_at(const Pose& pose, double deviation, double deviation_rho) {
  auto& random = mrpt::random::getRandomGenerator();
  const CPose2D middle = parts_->from_rack(pose);
  for (auto& particle : parts_->cloud.m_particles) {
    particle.d = {random.drawGaussian1D(middle.x(), deviation / 1000),
                  random.drawGaussian1D(middle.y(), deviation / 1000),
                  random.drawGaussian1D(middle.phi(), deviation_rho)};
    particle.log_w = 0;
  }
  parts_->estimate = pose;
  parts_->fresh = true;
}

void MrptFilter::start_anywhere() {
  parts_->cloud.resetUniformFreeSpace(parts_->grid.get());
  parts_->fresh = true;
}

bool MrptFilter::take(const Pose& odometry, const LogScan& scan, std::span<const BeamEnd> beams) {
  Parts& parts = *parts_;
  parts.odometry = odometry;
  if (parts.fresh) parts.taken = odometry;
  const Pose step = odometry - parts.taken;
  const bool moved = std::hypot(step.x, step.y) >= 1000 * parts.settings.distance_between ||
                     std::abs(signed_angle(step.rho)) >= parts.settings.turn_between;
  if (beams.empty() || (!parts.fresh && !moved)) return false;
  parts.taken = odometry;
  parts.fresh = false;
  // Uses every n-th point of the scan. Marking the others as invalid does not work, because MRPT
  // omits points without valid neighbours: two of sixty remained.
  parts.grid->likelihoodOptions.LF_decimation = static_cast<std::uint32_t>(
      std::max(1L, std::lround(static_cast<double>(beams.size()) / parts.settings.beams)));
  parts.step(step, parts.scan_of(scan, beams));
  return true;
}

Pose MrptFilter::pose() const { return parts_->estimate + (parts_->odometry - parts_->taken); }

double MrptFilter::likelihood(const Pose& robot, const LogScan& scan,
                              std::span<const BeamEnd> beams) const {
  const auto made = parts_->scan_of(scan, beams);
  return parts_->grid->computeObservationLikelihood(*made, CPose3D(parts_->from_rack(robot)));
}

}  // namespace rack::mcl_eval

#include "components/localisation/mcl_messages.h"

#include <algorithm>
#include <cmath>

namespace rack::localisation {

namespace {

constexpr i32 kDynamic = 3;
constexpr std::size_t kSamplesMax = 500;  // the rest is for measurements
constexpr double kSureShare = 0.9;
constexpr i32 kLayerOfMeasurements = 1;  // another colour

double deviation(double variance) { return std::sqrt(std::max(variance, 0.0)); }

}  // namespace

void beams_of(const Scan2dData& scan, i32 range_max, std::vector<BeamEnd>& ends) {
  ends.clear();
  for (const ScanPoint& point : scan.points) {
    constexpr i32 kUseless = scan_point::kInvalid | scan_point::kMaxRange;
    if ((point.type & kUseless) != 0 || (point.type & scan_point::kClassMask) == kDynamic) continue;
    if (point.z <= 0 || point.z >= range_max) continue;
    ends.push_back({static_cast<float>(point.x), static_cast<float>(point.y)});
  }
}

void to_message(const Localiser& localiser, TimeStamp time, MclData& data) {
  const Pose pose = localiser.pose();
  data.recordingTime = time;
  data.pos = pose.position();
  data.points.clear();
  const ParticleFilter& filter = localiser.filter();
  const std::size_t samples = std::min(filter.size(), kSamplesMax);
  for (std::size_t i = 0; i < samples; ++i) {
    const Pose sample = filter.particle(i * filter.size() / samples);
    data.points.push_back({.x = whole_millimetres(sample.x),
                           .y = whole_millimetres(sample.y),
                           .type = mcl_point::kSample});
  }
  const Beams& beams = localiser.beams();
  const std::size_t room = decltype(data.points)::kMax - samples;
  for (std::size_t i = 0; i < std::min(beams.size(), room); ++i) {
    const BeamEnd beam = beams[i];
    const auto x = static_cast<double>(beam.x);
    const auto y = static_cast<double>(beam.y);
    const Pose end = pose + Pose{.x = x, .y = y};
    data.points.push_back({.x = whole_millimetres(end.x),
                           .y = whole_millimetres(end.y),
                           .z = whole_millimetres(std::hypot(x, y)),
                           .type = mcl_point::kMeasurement,
                           .layer = kLayerOfMeasurements});
  }
}

PositionData to_update(const Localiser& localiser, TimeStamp time) {
  const Estimate now = localiser.now();
  const Covariance& covariance = now.covariance;
  PositionData position{.recordingTime = time, .pos = now.pose.position()};
  position.var.x = whole_millimetres(deviation(covariance.xx));
  position.var.y = whole_millimetres(deviation(covariance.yy));
  position.var.rho = static_cast<f32>(deviation(covariance.rho_rho));
  return position;
}

bool is_sure(const Estimate& estimate, double most) {
  const Covariance& c = estimate.covariance;
  return estimate.share >= kSureShare && deviation(c.xx) <= most && deviation(c.yy) <= most;
}

}  // namespace rack::localisation

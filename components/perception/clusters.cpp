#include "components/perception/clusters.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rack::perception {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kClustersPointsMax = decltype(Scan2dData::points)::kMax;

constexpr double kGapLeast = 100;  // mm between neighbours: noise
constexpr double kGapBeams = 2.5;  // times the spacing of beams
constexpr double kGapMost = 800;   // mm
constexpr double kLeg = 230;       // mm
constexpr double kPerson = 800;    // mm
constexpr double kBehind = 45;     // mm: the centre of a leg behind the mean of its visible points
constexpr double kLegWidth = 120;  // mm
constexpr double kPointsMost = 3;  // points that a near leg must have

double distance(const Sight& a, const Sight& b) { return std::hypot(a.x - b.x, a.y - b.y); }

}  // namespace

ClusterFinder::ClusterFinder() {
  chosen_.reserve(kClustersPointsMax);
  labels_.reserve(kClustersPointsMax);
  extents_.reserve(2 * kClustersPointsMax);
  begins_.reserve(2 * kClustersPointsMax + 1);
  order_.reserve(kClustersPointsMax);
  points_.reserve(kClustersPointsMax);
  clusters_.reserve(kClustersMax);
}

double ClusterFinder::Extent::size() const { return std::hypot(x_max - x_min, y_max - y_min); }

std::span<const Cluster> ClusterFinder::find(const ScanView& scan, double size_max) {
  const auto& sights = scan.sights();
  clusters_.clear();
  chosen_.clear();
  labels_.assign(sights.size(), kNone);
  labels_end_ = 0;
  for (std::uint32_t i = 0; i < sights.size(); ++i)
    if (sights[i].hit && !sights[i].explained) chosen_.push_back(i);
  sweep(scan);
  measure(scan);
  if (choose_moved(scan)) {
    sweep(scan);
    measure(scan);
  }
  gather(scan);
  for (std::uint32_t label = 0; label < labels_end_; ++label) {
    const std::uint32_t count = begins_[label + 1] - begins_[label];
    if (count == 0 || extents_[label].size() > size_max) continue;
    if (clusters_.size() == kClustersMax) break;
    const Cluster cluster = describe(scan, std::span(order_).subspan(begins_[label], count));
    // Otherwise it is a speck of dust, or the edge between two objects.
    const double expected = kLegWidth / 2 / std::max(cluster.spacing, 1.0);
    if (static_cast<double>(cluster.count) >= std::clamp(expected, 1.0, kPointsMost))
      clusters_.push_back(cluster);
  }
  return clusters_;
}

bool ClusterFinder::near(const ScanView& scan, const Sight& a, const Sight& b) {
  const double spread = kGapBeams * scan.spacing(std::min(a.away, b.away));
  return distance(a, b) <= std::min(kGapLeast + spread, kGapMost);
}

void ClusterFinder::sweep(const ScanView& scan) {
  const auto& sights = scan.sights();
  std::array<Open, kOpenMax> open{};
  std::size_t count = 0;
  for (const std::uint32_t at : chosen_) {
    // The newest cluster first: it is the most likely one.
    std::size_t found = 0;
    while (found < count && !near(scan, sights[at], sights[open[found].last])) ++found;
    Open into{.label = labels_end_, .last = at};
    if (found < count)
      into.label = open[found].label;
    else
      ++labels_end_;
    if (found == count && count < kOpenMax) ++count;
    for (std::size_t i = std::min(found, count - 1); i > 0; --i) open[i] = open[i - 1];
    open[0] = into;
    labels_[at] = into.label;
  }
  if (!scan.full_turn() || chosen_.empty()) return;
  const std::uint32_t first = labels_[chosen_.front()];
  for (std::size_t i = 0; i < count; ++i) {
    if (open[i].label == first || !near(scan, sights[chosen_.front()], sights[open[i].last]))
      continue;
    for (const std::uint32_t at : chosen_)
      if (labels_[at] == open[i].label) labels_[at] = first;
    return;
  }
}

void ClusterFinder::measure(const ScanView& scan) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  extents_.assign(labels_end_, {kFar, -kFar, kFar, -kFar, 0, 0});
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    if (labels_[i] == kNone) continue;
    const Sight& sight = scan.sights()[i];
    Extent& extent = extents_[labels_[i]];
    extent.x_min = std::min(extent.x_min, sight.x);
    extent.x_max = std::max(extent.x_max, sight.x);
    extent.y_min = std::min(extent.y_min, sight.y);
    extent.y_max = std::max(extent.y_max, sight.y);
    ++extent.count;
    if (sight.moved) ++extent.moved;
  }
}

// Chooses the moved points of clusters that are larger than a person and have moved in part.
bool ClusterFinder::choose_moved(const ScanView& scan) {
  chosen_.clear();
  for (std::uint32_t i = 0; i < labels_.size(); ++i) {
    if (labels_[i] == kNone || !scan.sights()[i].moved) continue;
    const Extent& extent = extents_[labels_[i]];
    if (extent.size() > kPerson && extent.moved < extent.count) chosen_.push_back(i);
  }
  return !chosen_.empty();
}

void ClusterFinder::gather(const ScanView& scan) {
  begins_.assign(labels_end_ + 1, 0);
  for (std::uint32_t label = 0; label < labels_end_; ++label)
    begins_[label + 1] = begins_[label] + extents_[label].count;
  order_.resize(begins_[labels_end_]);
  for (std::uint32_t i = 0; i < scan.sights().size(); ++i)
    if (labels_[i] != kNone) order_[begins_[labels_[i]]++] = i;
  // Filling has advanced each begin to that of the next label.
  for (std::uint32_t label = labels_end_; label > 0; --label) begins_[label] = begins_[label - 1];
  begins_[0] = 0;
}

Cluster ClusterFinder::describe(const ScanView& scan, std::span<const std::uint32_t> part) {
  Cluster cluster;
  cluster.count = part.size();
  cluster.away = std::numeric_limits<double>::infinity();
  points_.clear();
  MapPoint mean{};
  double moved = 0;
  for (const std::uint32_t at : part) {
    const Sight& sight = scan.sights()[at];
    points_.push_back({sight.x, sight.y});
    mean.x += sight.x / static_cast<double>(part.size());
    mean.y += sight.y / static_cast<double>(part.size());
    cluster.away = std::min(cluster.away, sight.away);
    moved += sight.moved ? 1 : 0;
    cluster.stood += sight.stood / static_cast<double>(part.size());
  }
  cluster.point = points_[points_.size() / 2];
  cluster.moved = moved / static_cast<double>(part.size());
  cluster.spacing = scan.spacing(cluster.away);
  cluster.size = extents_[labels_[part.front()]].size();
  cluster.leg = cluster.size <= kLeg + cluster.spacing;
  cluster.person = cluster.size <= kPerson + cluster.spacing;
  if (!cluster.person) {
    cluster.box = fit_box(points_);
    return cluster;
  }
  const double dx = mean.x - scan.scanner().x;
  const double dy = mean.y - scan.scanner().y;
  const double away = std::max(std::hypot(dx, dy), 1.0);
  cluster.box = {.centre = {mean.x + kBehind * dx / away, mean.y + kBehind * dy / away},
                 .heading = 0,
                 .length = cluster.size,
                 .width = cluster.size};
  return cluster;
}

}  // namespace rack::perception

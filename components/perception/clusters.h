// Groups the points of a scan into clusters. Pure.
//
// Consecutive points that are near each other belong to one cluster; the threshold grows with the
// range, as beams diverge (the adaptive jump distance of Borges and Aldon, 2004, linearised). Each
// point is compared with the last points of several clusters: in a merged scan near and far points
// alternate, and between two legs a beam passes through. Points of a large cluster that have moved
// become clusters of their own: a person who walks along a wall.
//
// A cluster is described by a box. One as small as a leg or a person has no useful direction: its
// centre is the mean of its points, shifted away from the scanner to account for the invisible back
// of a round leg. A larger one is the best fitting rectangle.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "components/perception/box_fit.h"
#include "components/perception/scan_view.h"

namespace rack::perception {

struct Cluster {
  Box box{};
  MapPoint point{};    // end point of its central beam
  double away = 0;     // mm, from the scanner to its nearest point
  double size = 0;     // mm, across all its points
  double spacing = 0;  // mm, between beams at its range
  double moved = 0;    // share of its points that have moved
  double stood = 0;    // s, mean of Sight::stood
  std::size_t count = 0;
  bool leg = false;     // as narrow as one leg
  bool person = false;  // at most as wide as a person; else its box is used
};

class ClusterFinder {
 public:
  static constexpr std::size_t kClustersMax = 1000;

  ClusterFinder();

  // Clusters of the hits that the map does not explain. Clusters larger than size_max are left out
  // (walls). At most kClustersMax; those at the end of the scan are left out.
  std::span<const Cluster> find(const ScanView& scan, double size_max);

 private:
  static constexpr std::size_t kOpenMax = 6;
  struct Extent {
    double x_min;
    double x_max;
    double y_min;
    double y_max;
    std::uint32_t count;
    std::uint32_t moved;
    [[nodiscard]] double size() const;
  };
  struct Open {
    std::uint32_t label;
    std::uint32_t last;
  };
  void sweep(const ScanView& scan);
  [[nodiscard]] static bool near(const ScanView& scan, const Sight& a, const Sight& b);
  void measure(const ScanView& scan);
  bool choose_moved(const ScanView& scan);
  void gather(const ScanView& scan);
  [[nodiscard]] Cluster describe(const ScanView& scan, std::span<const std::uint32_t> part);

  std::vector<std::uint32_t> chosen_;  // of the sights, for this sweep
  std::vector<std::uint32_t> labels_;  // of each sight
  std::vector<Extent> extents_;        // of each label
  std::vector<std::uint32_t> begins_;  // of each label, in order_
  std::vector<std::uint32_t> order_;   // sights by their labels
  std::vector<MapPoint> points_;
  std::vector<Cluster> clusters_;
  std::uint32_t labels_end_ = 0;
};

}  // namespace rack::perception

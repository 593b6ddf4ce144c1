// The points of a scan that belong together. Pure.
//
// Points that follow each other and are near belong together; how near depends on how far away they
// are, as beams spread (the adaptive jump distance of Borges and Aldon, 2004, linearised). Each
// point is compared with the last ones of several clusters, and not of one only: in a merged scan
// near and far points come in turns, and between two legs a beam goes through. Of a large cluster
// the points that have moved become clusters of their own: a person who walks along a wall.
//
// A cluster is said as a box. What is as small as a leg or a person has no directions to speak of:
// its centre is the mean of its points, moved away from the scanner by what of a round leg lies
// behind them. A larger one is the rectangle that fits best.
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
  MapPoint point{};    // where a beam in its middle ended
  double away = 0;     // mm, from the scanner to its nearest point
  double size = 0;     // mm, across all its points
  double spacing = 0;  // mm, of beams there
  double moved = 0;    // share of its points
  double stood = 0;    // s, mean of its points
  std::size_t count = 0;
  bool leg = false;     // as narrow as one leg
  bool person = false;  // as narrow as a person at most; else its box counts
};

class ClusterFinder {
 public:
  static constexpr std::size_t kClustersMax = 1000;

  ClusterFinder();

  // Of what was hit and the map does not explain. What is larger than size_max is left out (walls).
  // No more than kClustersMax, those at the end of the scan are left out.
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

// Tracks clusters over scans as objects with a constant number. Pure.
//
// Each cluster is assigned to the object that it fits best: among all pairs within the gate (a
// Mahalanobis distance that 99 % of the correct pairs have) the nearest first, confirmed objects
// before new ones. A person may get two clusters, if the second one is within the distance of a
// second leg. The remaining clusters start new objects, legs in pairs. An object is confirmed when
// three of five scans show it, and published until half a second after the last sighting. It is
// dropped when scans see through the place where it should be; where they do not, it may be hidden:
// its number is kept for a second, or for five if it was standing. Nearest pairs first gives the
// same result as the optimal assignment (Hungarian method), except where two people cross within a
// stride, where both are ambiguous.
#pragma once

#include <span>
#include <vector>

#include "components/perception/track.h"

namespace rack::perception {

struct TrackerSettings {
  bool only_moved = true;  // without a map: objects start only where earlier scans saw free space
};

class ObjectTracker {
 public:
  static constexpr std::size_t kTracksMax = 200;

  explicit ObjectTracker(const TrackerSettings& settings);

  // `now`: the free space of the scan. `seconds`: its time, greater than that of the last one.
  void take(std::span<const Cluster> clusters, const MapPoint& scanner, const FreeTable& now,
            double seconds);
  void forget();
  // Forgets the object of that number; false: there is none.
  bool stop(std::int32_t id);

  [[nodiscard]] std::span<const Track> tracks() const { return tracks_; }

 private:
  static constexpr std::size_t kPairsMax = 8192;
  struct Pair {
    double distance;
    std::uint32_t track;
    std::uint32_t cluster;
  };
  struct Part {
    std::uint32_t first = 0;  // clusters of a track
    std::uint32_t second = 0;
    std::uint32_t count = 0;
  };
  void find_pairs();
  void assign();
  [[nodiscard]] bool joins(const Part& part, std::uint32_t cluster) const;
  [[nodiscard]] Sighting sighting(const Part& part) const;
  void begin_tracks(double seconds);
  [[nodiscard]] bool may_begin(const Cluster& cluster) const;
  [[nodiscard]] static bool are_one(const Track& a, const Track& b);
  [[nodiscard]] bool is_room(const Track& track) const;
  void drop();

  TrackerSettings settings_;
  std::vector<Track> tracks_;
  std::vector<Part> parts_;  // of each track
  std::vector<Pair> pairs_;
  std::vector<bool> taken_;   // clusters
  std::vector<bool> doomed_;  // tracks
  std::span<const Cluster> clusters_;
  MapPoint scanner_{};
  std::int32_t next_id_ = 1;
};

}  // namespace rack::perception

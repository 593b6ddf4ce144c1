// Clusters of scan after scan become objects that keep their number. Pure.
//
// Each cluster goes to the object that it fits best: of all pairs within the gate (a Mahalanobis
// distance that 99 % of the right ones have) the nearest first, confirmed objects before those that
// are new. A person gets two of them, if the second is as near as a second leg is. What is left
// over begins new objects, legs by pairs. An object is believed when three of five scans show it,
// and told until half a second after the last one did. It is given up when scans look through where
// it should be; where they do not, it may be hidden: its number is kept for a second, or for five
// if it stood. Nearest pairs first instead of the best assignment of
// all (Hungarian method): they differ where two people cross within a stride, where neither knows.
#pragma once

#include <span>
#include <vector>

#include "components/perception/track.h"

namespace rack::perception {

struct TrackerSettings {
  bool only_moved = true;  // without a map: an object begins where earlier scans looked through
};

class ObjectTracker {
 public:
  static constexpr std::size_t kTracksMax = 200;

  explicit ObjectTracker(const TrackerSettings& settings);

  // `now`: what the scan saw. `seconds`: its time, more than the last one's.
  void take(std::span<const Cluster> clusters, const MapPoint& scanner, const FreeTable& now,
            double seconds);
  void forget();
  // The object of that number; false: there is none.
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

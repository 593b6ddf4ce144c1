// A path for a car among obstacles. Pure.
//
// Hybrid A* (Dolgov, Thrun, Montemerlo and Diebel, Path Planning for Autonomous Vehicles in Unknown
// Semi-structured Environments, 2010): a search over poses instead of cells. From each pose the car
// drives a short arc to the left, to the right, or straight ahead, forward and backward; among the
// poses in one bin of place and heading, the cheapest is kept. The remaining cost is estimated by
// the path over the map's cells to the goal, as if the car could turn at rest. From time to time
// the shortest path of a car without obstacles (Reeds and Shepp) is tried from a pose: when it is
// free, it completes the path. Finally the path is shortened: where such a direct path between two
// of its poses is free, it replaces the part between them.
#pragma once

#include <vector>

#include "components/path/grid_search.h"
#include "components/path/reeds_shepp.h"

namespace rack::path {

class HybridSearch {
 public:
  struct Settings {
    double radius = 1000;  // mm
    HullDiscs hull{{}};
    double backward = 1.5;  // cost factor of driving backward
    double change = 2000;   // cost of a change between forward and backward, mm
  };
  enum class Progress : std::uint8_t { kSearching, kFound, kFailed };

  HybridSearch();  // allocates the memory for maps of 40 m

  // Start and goal must be in the map. `space` must outlive the search.
  void begin(const FreeSpace& space, const Settings& settings, const Pose& start, const Pose& goal);
  // Expands that many poses.
  Progress advance(int poses);

  [[nodiscard]] std::span<const Piece> pieces() const { return pieces_; }
  [[nodiscard]] std::size_t looked_at() const { return closed_; }
  // Whether the vehicle has room along all pieces.
  [[nodiscard]] bool is_free(const Pose& from, std::span<const Piece> pieces) const;

 private:
  struct Node {
    Pose at{};
    double cost = 0;
    std::int32_t parent = -1;
    Piece by{};  // from the parent
    bool closed = false;
  };
  struct Entry {
    double priority;
    std::int32_t node;
    friend bool operator<(const Entry& a, const Entry& b) { return a.priority > b.priority; }
  };
  void open(const Node& node);
  void look_around(std::int32_t index);
  bool try_the_rest(std::int32_t index);
  void finish(std::int32_t index, std::span<const Piece> rest);
  void shorten();
  void merge();
  [[nodiscard]] double room(const Pose& at) const;
  [[nodiscard]] std::size_t bin_of(const Pose& at) const;
  [[nodiscard]] double cost_of(const Piece& piece, const Piece& before) const;
  [[nodiscard]] double price(std::span<const Piece> pieces) const;

  const FreeSpace* space_ = nullptr;
  Settings settings_{};
  Pose start_{};
  Pose goal_{};
  double start_room_ = 0;
  double bin_ = 400;  // mm
  std::size_t rows_ = 0;
  std::size_t columns_ = 0;
  GridSearch to_goal_;
  std::vector<std::int32_t> bins_;  // index of the node of each bin, -1: none
  std::vector<Node> nodes_;
  std::vector<Entry> open_;
  std::vector<Piece> pieces_;
  std::vector<Piece> shorter_;
  std::size_t closed_ = 0;
  int until_try_ = 0;
};

}  // namespace rack::path

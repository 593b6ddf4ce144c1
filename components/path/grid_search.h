// The shortest path over the cells of a map. Pure.
//
// A*: cells are expanded in the order of the cost so far plus the least remaining cost, the length
// of a straight path over a grid with diagonals; a cell is expanded first by its shortest path
// (Hart, Nilsson and Raphael, 1968). Without a destination the remaining cost is 0, and all cells
// are reached (Dijkstra): a search from the goal gives the distance of every place to it. Cells
// near obstacles may cost more, so that the path keeps away from them where it can.
#pragma once

#include <vector>

#include "components/path/free_space.h"

namespace rack::path {

class GridSearch {
 public:
  struct Settings {
    double room = 0;         // clearance that each cell needs, mm
    double comfort = 0;      // additional clearance from which on a cell costs nothing extra, mm
    std::size_t stride = 1;  // cells of the map per cell of the search, in each direction
    // Within this distance of a place, that clearance is enough.
    Place eased_at{};
    double eased_within = 0;  // mm
    double eased_room = 0;    // mm
    double cost_max = 1e9;    // places that cost more are not searched, mm
  };
  // Allocates memory for maps of that size; it grows when necessary.
  void reserve(std::size_t cells);

  // False: there is no path; or, without a destination, no room at the start. A start or goal
  // without room counts as free: the caller has chosen it.
  bool run(const FreeSpace& space, const Settings& settings, const Place& from, const Place* to);

  // Cost of the last run, mm; infinite at places that were not reached.
  [[nodiscard]] double cost(const Place& place) const;
  // The path from a reached place to the start: centres of cells.
  void trace(const Place& from, std::vector<Place>& trace) const;

 private:
  struct Entry {
    float priority;
    std::uint32_t cell;
    friend bool operator<(const Entry& a, const Entry& b) { return a.priority > b.priority; }
  };
  void look_around(const FreeSpace& space, std::uint32_t cell, const Place* to);
  [[nodiscard]] float weight_of(const FreeSpace& space, const Place& at) const;
  void push(std::uint32_t cell, float cost, const Place* to);
  [[nodiscard]] std::uint32_t cell_of(const Place& place) const;
  [[nodiscard]] Place place_of(std::uint32_t cell) const;

  Settings settings_{};
  Place corner_{};
  double step_ = 0;
  std::size_t rows_ = 0;
  std::size_t columns_ = 0;
  std::vector<float> costs_;
  std::vector<float> weights_;         // 0: not computed yet; negative: no room
  std::vector<std::uint8_t> parents_;  // direction of the predecessor
  std::vector<std::uint8_t> done_;
  std::vector<Entry> open_;
};

}  // namespace rack::path

// The shortest way over the cells of a map. Pure.
//
// A*: cells are visited in the order of the way to them plus what is left at least, as the crow
// flies over a grid with diagonals; what is visited first is reached by the shortest way (Hart,
// Nilsson and Raphael, 1968). Without a place to go to nothing is left, and all cells are reached
// (Dijkstra): so a search from the goal says of every place how far it is from there. Cells near
// obstacles may be made dearer, so that the way keeps away from them where it can.
#pragma once

#include <vector>

#include "components/path/free_space.h"

namespace rack::path {

class GridSearch {
 public:
  struct Settings {
    double room = 0;         // what each cell needs, mm
    double comfort = 0;      // with so much more, it costs nothing extra
    std::size_t stride = 1;  // so many cells of the map in each direction are one
  };
  // Memory for maps of that size; grows when it must.
  void reserve(std::size_t cells);

  // False: there is no way; or, without a place to go to, no room at the start. A start or goal
  // without room counts as free: who looks from there knows it.
  bool run(const FreeSpace& space, const Settings& settings, const Place& from, const Place* to);

  // Of the last run, mm; infinite where it did not get.
  [[nodiscard]] double cost(const Place& place) const;
  // From a place it got to, to where it began: centres of cells.
  void trace(const Place& from, std::vector<Place>& way) const;

 private:
  struct Entry {
    float priority;
    std::uint32_t cell;
    friend bool operator<(const Entry& a, const Entry& b) { return a.priority > b.priority; }
  };
  void look_around(const FreeSpace& space, std::uint32_t cell, const Place* to);
  void push(std::uint32_t cell, float cost, const Place* to);
  [[nodiscard]] std::uint32_t cell_of(const Place& place) const;
  [[nodiscard]] Place place_of(std::uint32_t cell) const;

  Settings settings_{};
  Place corner_{};
  double step_ = 0;
  std::size_t rows_ = 0;
  std::size_t columns_ = 0;
  std::vector<float> costs_;
  std::vector<float> weights_;         // 0: not looked at yet; negative: no room
  std::vector<std::uint8_t> parents_;  // the direction it was reached from
  std::vector<std::uint8_t> done_;
  std::vector<Entry> open_;
};

}  // namespace rack::path

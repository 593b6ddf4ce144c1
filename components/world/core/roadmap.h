// The paths that people can walk: places with room around them, sampled at random, and joined where
// a person has room along the straight line between them (a probabilistic roadmap: Kavraki,
// Svestka, Latombe and Overmars 1996). A table holds the next place of the shortest path between
// any two places, by Dijkstra from each place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "components/geometry/random.h"
#include "components/world/core/scenery.h"

namespace rack::world {

class Roadmap {
 public:
  static constexpr std::size_t kPlacesMax = 300;
  static constexpr std::size_t kLinksMax = 12;  // per place, to the nearest

  Roadmap() = default;
  // `radius`: of a person; `wanted`: places that must be included.
  Roadmap(const Scenery& scenery, const Area& area, double radius, std::uint64_t seed,
          std::span<const MapPoint> wanted = {});

  // Each place can be reached from each other.
  [[nodiscard]] std::size_t size() const { return places_.size(); }
  [[nodiscard]] const MapPoint& place(std::size_t number) const { return places_[number]; }
  // The index of a wanted place; none when it has no room or cannot be reached.
  [[nodiscard]] std::optional<std::size_t> find(const MapPoint& wanted) const;
  // The next place on the path from one place to another.
  [[nodiscard]] std::size_t next(std::size_t from, std::size_t to) const {
    return next_[to * size() + from];
  }
  // The distance that a person can keep beside the line between two joined places.
  [[nodiscard]] double room(std::size_t from, std::size_t to) const;

 private:
  struct Link {
    std::size_t to = 0;
    double length = 0;
    double room = 0;
  };
  using Links = std::vector<std::vector<Link>>;

  void throw_places(const Scenery& scenery, const Area& area, double radius, Random& random);
  [[nodiscard]] Links joined(const Scenery& scenery, double radius) const;
  void keep_largest(Links& links);
  void find_paths(const Links& links);

  std::vector<MapPoint> places_;
  Links links_;
  std::vector<std::uint16_t> next_;
};

}  // namespace rack::world

// Ways that people can walk: places with room round them, thrown at random over the ground, and
// joined where a person fits through all along the straight line between them (a probabilistic
// roadmap: Kavraki, Svestka, Latombe and Overmars 1996). Which place comes next on the shortest way
// to which other is a table, by Dijkstra from each place.
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
  static constexpr std::size_t kLinksMax = 12;  // of a place, to the nearest

  Roadmap() = default;
  // `radius`: what a person needs; `wanted`: places that shall be among them.
  Roadmap(const Scenery& scenery, const Area& area, double radius, std::uint64_t seed,
          std::span<const MapPoint> wanted = {});

  // All places can be reached from all.
  [[nodiscard]] std::size_t size() const { return places_.size(); }
  [[nodiscard]] const MapPoint& place(std::size_t number) const { return places_[number]; }
  // A wanted one; none when nobody fits there, or comes there.
  [[nodiscard]] std::optional<std::size_t> find(const MapPoint& wanted) const;
  // The next place from one on the way to another.
  [[nodiscard]] std::size_t next(std::size_t from, std::size_t to) const {
    return next_[to * size() + from];
  }
  // Of two that are joined: how far beside the line a person still has its radius.
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
  void find_ways(const Links& links);

  std::vector<MapPoint> places_;
  Links links_;
  std::vector<std::uint16_t> next_;
};

}  // namespace rack::world

#include "components/path/place_aside.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rack::path {
namespace {

// Between the lane and the hull, mm: a person passes easily, passes, squeezes through.
constexpr std::array<double, 3> kBesideLane = {900, 650, 400};
constexpr double kLeavesWithin = 1000;  // mm: a vehicle too near to an obstacle is free after that

bool is_beside(const Place& place, std::span<const Place> lane, double distance) {
  return std::ranges::none_of(lane, [&](const Place& on_lane) {
    return std::hypot(place.x - on_lane.x, place.y - on_lane.y) < distance;
  });
}

}  // namespace

std::optional<Place> place_aside(const FreeSpace& space, GridSearch& cells,
                                 const AsideSettings& settings, const Place& from,
                                 std::span<const Place> lane) {
  const GridSearch::Settings search{
      .room = settings.room_to_pass,
      .eased_at = from,
      .eased_within = kLeavesWithin,
      .eased_room = std::max(space.clearance(from) - space.cell(), settings.half_width),
      .cost_max = kAsideMost};
  if (!cells.run(space, search, from, nullptr)) return std::nullopt;
  for (const double beside : kBesideLane) {
    std::optional<Place> nearest;
    double least_cost = kAsideMost;
    for (std::size_t row = 0; row < space.rows(); ++row) {
      for (std::size_t column = 0; column < space.columns(); ++column) {
        const Place place = space.center_of(row, column);
        const double cost = cells.cost(place);
        if (cost >= least_cost || space.clearance(place) < settings.room_to_turn ||
            !is_beside(place, lane, beside + settings.half_width))
          continue;
        least_cost = cost;
        nearest = place;
      }
    }
    if (nearest) return nearest;
  }
  return std::nullopt;
}

}  // namespace rack::path

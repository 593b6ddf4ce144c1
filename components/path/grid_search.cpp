#include "components/path/grid_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace rack::path {

namespace {

constexpr float kUnreached = std::numeric_limits<float>::infinity();
constexpr float kDear = 2;  // additional cost factor of a cell without spare room
constexpr double kDiagonal = 1.4142136;

struct Step {
  int row;
  int column;
  double length;
};
constexpr std::array<Step, 8> kDirections = {{{1, 0, 1},
                                              {-1, 0, 1},
                                              {0, 1, 1},
                                              {0, -1, 1},
                                              {1, 1, kDiagonal},
                                              {1, -1, kDiagonal},
                                              {-1, 1, kDiagonal},
                                              {-1, -1, kDiagonal}}};
constexpr std::uint8_t kNoParent = kDirections.size();

}  // namespace

void GridSearch::reserve(std::size_t cells) {
  costs_.reserve(cells);
  weights_.reserve(cells);
  parents_.reserve(cells);
  done_.reserve(cells);
  open_.reserve(2 * cells);
}

std::uint32_t GridSearch::cell_of(const Place& place) const {
  const auto part = [&](double at, double corner, std::size_t count) {
    return static_cast<std::size_t>(
        std::clamp((at - corner) / step_, 0.0, static_cast<double>(count) - 0.5));
  };
  return static_cast<std::uint32_t>(part(place.x, corner_.x, rows_) * columns_ +
                                    part(place.y, corner_.y, columns_));
}

Place GridSearch::place_of(std::uint32_t cell) const {
  const std::size_t row = cell / columns_;
  const std::size_t column = cell % columns_;
  return {corner_.x + (static_cast<double>(row) + 0.5) * step_,
          corner_.y + (static_cast<double>(column) + 0.5) * step_};
}

bool GridSearch::run(const FreeSpace& space, const Settings& settings, const Place& from,
                     const Place* to) {
  settings_ = settings;
  corner_ = space.corner();
  step_ = space.cell() * static_cast<double>(settings.stride);
  rows_ = (space.rows() + settings.stride - 1) / settings.stride;
  columns_ = (space.columns() + settings.stride - 1) / settings.stride;
  const std::size_t cells = rows_ * columns_;
  costs_.assign(cells, kUnreached);
  weights_.assign(cells, 0);
  parents_.assign(cells, kNoParent);
  done_.assign(cells, 0);
  open_.clear();
  if (!space.contains(from) || (to != nullptr && !space.contains(*to))) return false;
  const std::uint32_t goal = to == nullptr ? 0 : cell_of(*to);
  if (to != nullptr) weights_[goal] = 1;
  push(cell_of(from), 0, to);
  while (!open_.empty()) {
    std::pop_heap(open_.begin(), open_.end());
    const std::uint32_t cell = open_.back().cell;
    open_.pop_back();
    if (done_[cell] != 0) continue;
    done_[cell] = 1;
    if (to != nullptr && cell == goal) return true;
    if (static_cast<double>(costs_[cell]) > settings.cost_max) break;
    look_around(space, cell, to);
  }
  return to == nullptr;
}

void GridSearch::push(std::uint32_t cell, float cost, const Place* to) {
  costs_[cell] = cost;
  double left = 0;
  if (to != nullptr) {
    const Place at = place_of(cell);
    const double x = std::abs(at.x - to->x);
    const double y = std::abs(at.y - to->y);
    // The destination is a point within its cell: the estimate must not exceed the real cost.
    left = std::max(0.0, std::max(x, y) + (kDiagonal - 1) * std::min(x, y) - step_);
  }
  open_.push_back({cost + static_cast<float>(left), cell});
  std::push_heap(open_.begin(), open_.end());
}

void GridSearch::look_around(const FreeSpace& space, std::uint32_t cell, const Place* to) {
  const auto row = static_cast<int>(cell / columns_);
  const auto column = static_cast<int>(cell % columns_);
  for (std::size_t i = 0; i < kDirections.size(); ++i) {
    const int next_row = row + kDirections[i].row;
    const int next_column = column + kDirections[i].column;
    if (next_row < 0 || next_column < 0 || next_row >= static_cast<int>(rows_) ||
        next_column >= static_cast<int>(columns_))
      continue;
    const auto next = static_cast<std::uint32_t>(static_cast<std::size_t>(next_row) * columns_ +
                                                 static_cast<std::size_t>(next_column));
    if (done_[next] != 0) continue;
    float& weight = weights_[next];
    if (weight == 0) weight = weight_of(space, place_of(next));
    if (weight < 0) continue;
    const float cost = costs_[cell] + static_cast<float>(kDirections[i].length * step_) * weight;
    if (cost >= costs_[next]) continue;
    parents_[next] = static_cast<std::uint8_t>(i);
    push(next, cost, to);
  }
}

// The cost of a cell for each mm; negative: no room.
float GridSearch::weight_of(const FreeSpace& space, const Place& at) const {
  const double clearance = space.clearance(at);
  const double spare = clearance - settings_.room;
  if (spare < 0) {
    const Place& eased = settings_.eased_at;
    const bool is_eased = std::hypot(at.x - eased.x, at.y - eased.y) <= settings_.eased_within;
    return is_eased && clearance >= settings_.eased_room ? 1 + kDear : -1.0F;
  }
  if (settings_.comfort <= 0) return 1;
  return 1 + kDear * static_cast<float>(std::max(0.0, 1 - spare / settings_.comfort));
}

double GridSearch::cost(const Place& place) const {
  const double x = place.x - corner_.x;
  const double y = place.y - corner_.y;
  const bool inside = x >= 0 && y >= 0 && x < step_ * static_cast<double>(rows_) &&
                      y < step_ * static_cast<double>(columns_);
  return inside ? static_cast<double>(costs_[cell_of(place)]) : static_cast<double>(kUnreached);
}

void GridSearch::trace(const Place& from, std::vector<Place>& trace) const {
  trace.clear();
  std::uint32_t cell = cell_of(from);
  while (parents_[cell] != kNoParent && trace.size() < costs_.size()) {
    trace.push_back(place_of(cell));
    const Step& step = kDirections[parents_[cell]];
    const auto back = static_cast<std::int64_t>(cell) -
                      step.row * static_cast<std::int64_t>(columns_) - step.column;
    cell = static_cast<std::uint32_t>(back);
  }
  trace.push_back(place_of(cell));
}

}  // namespace rack::path

#include "components/mapping/scan_search.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rack::mapping {

namespace {

constexpr std::int32_t kBlur = 2;       // cells around a point
constexpr double kBlurDeviation = 1.2;  // cells
constexpr std::int64_t kScanSearchCellsMax = 8'000'000;
constexpr double kTurnStep = radians(0.4);  // with cells of kCell
constexpr double kTurnStepMost = radians(0.7);
// Within this turn all directions are tried, also those for which walls do not fit.
constexpr double kTurnAlways = radians(6);
constexpr float kDirectionsFit = 0.8F;  // of the best fit
constexpr std::ptrdiff_t kDirectionsBlur = 2;
// What a shift as long as the window costs, of the score: of poses that fit alike, as along a bare
// corridor, the nearest is the most probable.
constexpr double kShiftCosts = 0.1;

}  // namespace

ScanSearch::ScanSearch(std::span<const ScanPoint2d> others, double cell, std::size_t levels)
    : cell_(cell), turn_step_(std::min(kTurnStepMost, kTurnStep * cell / kCell)) {
  if (others.empty()) return;
  double high_x = -1e9;
  double high_y = -1e9;
  low_x_ = low_y_ = 1e9;
  for (const ScanPoint2d& p : others) {
    low_x_ = std::min(low_x_, static_cast<double>(p.x));
    low_y_ = std::min(low_y_, static_cast<double>(p.y));
    high_x = std::max(high_x, static_cast<double>(p.x));
    high_y = std::max(high_y, static_cast<double>(p.y));
  }
  // A square that begins in the margin may reach into the grid.
  const double margin = cell_ * (1 << (levels - 1));
  low_x_ -= margin;
  low_y_ -= margin;
  const double rows = std::floor((high_x - low_x_) / cell_) + 2 + kBlur;
  const double columns = std::floor((high_y - low_y_) / cell_) + 2 + kBlur;
  if (!(rows * columns < kScanSearchCellsMax)) return;
  rows_ = static_cast<std::int32_t>(rows);
  columns_ = static_cast<std::int32_t>(columns);
  levels_.resize(levels);
  levels_[0].resize(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_));
  for (const ScanPoint2d& p : others) draw(p);
  for (std::size_t level = 1; level < levels; ++level) widen(level);
  directions_ = directions_of(others);
}

ScanSearch::Directions ScanSearch::directions_of(std::span<const ScanPoint2d> points) {
  Directions sharp{};
  for (const ScanPoint2d& p : points) {
    if (!p.on_wall()) continue;
    const double at = heading(static_cast<double>(std::atan2(p.ny, p.nx))) / (2 * kPi);
    sharp[static_cast<std::size_t>(at * kDirections) % kDirections] += 1;
  }
  Directions blurred{};
  for (std::size_t i = 0; i < kDirections; ++i)
    for (std::ptrdiff_t k = -kDirectionsBlur; k <= kDirectionsBlur; ++k)
      blurred[i] += sharp[(i + kDirections + static_cast<std::size_t>(k)) % kDirections] *
                    static_cast<float>(kDirectionsBlur + 1 - std::abs(k));
  return blurred;
}

// The directions to try, relative to `middle`.
std::vector<double> ScanSearch::turns(std::span<const ScanPoint2d> scan, double middle,
                                      double window) const {
  const int steps = static_cast<int>(std::ceil(window / turn_step_));
  std::vector<double> turns;
  if (window <= kTurnAlways) {
    for (int turn = -steps; turn <= steps; ++turn) turns.push_back(turn * turn_step_);
    return turns;
  }
  const Directions own = directions_of(scan);
  std::vector<float> fits;
  float best = 0;
  for (int turn = -steps; turn <= steps; ++turn) {
    const double shift = heading(middle + turn * turn_step_) / (2 * kPi) * kDirections;
    const std::size_t by = static_cast<std::size_t>(std::llround(shift)) % kDirections;
    float fit = 0;
    for (std::size_t i = 0; i < kDirections; ++i)
      fit += own[i] * directions_[(i + by) % kDirections];
    fits.push_back(fit);
    best = std::max(best, fit);
  }
  for (int turn = -steps; turn <= steps; ++turn)
    if (fits[static_cast<std::size_t>(turn + steps)] >= kDirectionsFit * best)
      turns.push_back(turn * turn_step_);
  return turns;
}

void ScanSearch::draw(const ScanPoint2d& point) {
  const double x = (static_cast<double>(point.x) - low_x_) / cell_;
  const double y = (static_cast<double>(point.y) - low_y_) / cell_;
  const auto row = static_cast<std::int32_t>(x);
  const auto column = static_cast<std::int32_t>(y);
  for (std::int32_t r = row - kBlur; r <= row + kBlur; ++r)
    for (std::int32_t c = column - kBlur; c <= column + kBlur; ++c) {
      const double off = std::hypot(r + 0.5 - x, c + 0.5 - y) / kBlurDeviation;
      const auto value = static_cast<std::uint8_t>(255 * std::exp(-off * off / 2));
      auto& most = levels_[0][cell(r, c)];
      most = std::max(most, value);
    }
}

// Computes a level from squares of half the side.
void ScanSearch::widen(std::size_t level) {
  const auto& from = levels_[level - 1];
  auto& to = levels_[level];
  to.resize(from.size());
  const std::int32_t half = 1 << (level - 1);
  for (std::int32_t r = 0; r < rows_; ++r)
    for (std::int32_t c = 0; c < columns_; ++c) {
      std::uint8_t most = 0;
      for (const std::int32_t row : {r, r + half})
        for (const std::int32_t column : {c, c + half})
          if (row < rows_ && column < columns_) most = std::max(most, from[cell(row, column)]);
      to[cell(r, c)] = most;
    }
}

// The points of a scan rotated to one direction, as cells, and the maximum shift.
struct ScanSearch::Turned {
  std::vector<Offset> points{};
  std::int32_t shift_max = 0;
  // Shifts nearer than this to `except` are not wanted.
  double cost = 0;  // of a shift by a cell
  double except_row = 0;
  double except_column = 0;
  double except_shifts = 0;

  [[nodiscard]] bool is_excepted(const Square& at) const {
    return except_shifts > 0 &&
           std::hypot(at.row - except_row, at.column - except_column) < except_shifts;
  }
};

std::uint32_t ScanSearch::sum(std::size_t level, const Turned& turned, std::int32_t row,
                              std::int32_t column) const {
  const auto& cells = levels_[level];
  std::uint32_t all = 0;
  for (const Offset& p : turned.points) {
    const std::int32_t r = p.row + row;
    const std::int32_t c = p.column + column;
    if (r < 0 || c < 0 || r >= rows_ || c >= columns_) continue;
    all += cells[cell(r, c)];
  }
  // The smallest shift of the square.
  const std::int32_t last = (1 << level) - 1;
  const auto least = [&](std::int32_t from) { return from > 0 ? from : std::min(0, from + last); };
  const double costs = turned.cost * std::hypot(least(row), least(column));
  return all - std::min(all, static_cast<std::uint32_t>(costs));
}

void ScanSearch::descend(const Turned& turned, std::size_t level, const Square& square,
                         std::uint32_t& best_sum, std::optional<Square>& best) const {
  if (square.sum <= best_sum) return;
  if (level == 0) {
    if (turned.is_excepted(square)) return;
    best_sum = square.sum;
    best = square;
    return;
  }
  const std::int32_t half = 1 << (level - 1);
  std::array<Square, 4> parts{};  // best first, so that it excludes others
  std::size_t count = 0;
  for (const std::int32_t row : {square.row, square.row + half})
    for (const std::int32_t column : {square.column, square.column + half}) {
      if (row > turned.shift_max || column > turned.shift_max) continue;
      std::size_t at = count++;
      const Square part{row, column, sum(level - 1, turned, row, column)};
      for (; at > 0 && parts[at - 1].sum < part.sum; --at) parts[at] = parts[at - 1];
      parts[at] = part;
    }
  for (std::size_t i = 0; i < count; ++i) descend(turned, level - 1, parts[i], best_sum, best);
}

void ScanSearch::turn(std::span<const ScanPoint2d> scan, const Pose& middle, double rho,
                      Turned& turned) const {
  const double c = std::cos(rho);
  const double s = std::sin(rho);
  turned.points.clear();
  for (const ScanPoint2d& p : scan) {
    const auto x = static_cast<double>(p.x);
    const auto y = static_cast<double>(p.y);
    const double row = (middle.x + c * x - s * y - low_x_) / cell_;
    const double column = (middle.y + s * x + c * y - low_y_) / cell_;
    if (std::abs(row) > 1e6 || std::abs(column) > 1e6) continue;
    turned.points.push_back({static_cast<std::int32_t>(std::floor(row)),
                             static_cast<std::int32_t>(std::floor(column))});
  }
}

std::optional<ScanSearch::Found> ScanSearch::find(std::span<const ScanPoint2d> scan,
                                                  const Pose& middle, const Window& window,
                                                  double least, const Except& except) const {
  if (levels_.empty() || scan.empty()) return std::nullopt;
  auto best_sum = static_cast<std::uint32_t>(least * 255 * static_cast<double>(scan.size()));
  std::optional<Found> found;
  Turned turned{.shift_max = static_cast<std::int32_t>(std::ceil(window.distance / cell_)),
                .cost = kShiftCosts * 255 * static_cast<double>(scan.size()) * cell_ /
                        std::max(window.distance, cell_),
                .except_row = (except.pose.x - middle.x) / cell_,
                .except_column = (except.pose.y - middle.y) / cell_,
                .except_shifts = except.distance / cell_};
  // The highest level whose squares are not larger than the window.
  std::size_t top = levels_.size() - 1;
  while (top > 3 && (1 << (top - 1)) > turned.shift_max) --top;
  const std::int32_t side = 1 << top;
  std::vector<Square> squares;
  for (const double by : turns(scan, middle.rho, window.turn)) {
    const double rho = middle.rho + by;
    turn(scan, middle, rho, turned);
    squares.clear();
    for (std::int32_t r = -turned.shift_max; r <= turned.shift_max; r += side)
      for (std::int32_t q = -turned.shift_max; q <= turned.shift_max; q += side)
        squares.push_back({r, q, sum(top, turned, r, q)});
    std::ranges::sort(squares, std::greater{}, &Square::sum);
    std::optional<Square> best;
    for (const Square& square : squares) descend(turned, top, square, best_sum, best);
    if (!best) continue;
    found = Found{{.x = middle.x + best->row * cell_,
                   .y = middle.y + best->column * cell_,
                   .rho = heading(rho)},
                  best_sum / (255.0 * static_cast<double>(scan.size()))};
  }
  return found;
}

}  // namespace rack::mapping

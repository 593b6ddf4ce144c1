#include "components/mapping/scan_search.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rack::mapping {

namespace {

constexpr std::size_t kLevels = 6;  // squares of the last level have sides of 32 cells
constexpr std::int32_t kScanSearchMargin = 1 << (kLevels - 1);
constexpr std::int32_t kBlur = 2;      // cells around a point
constexpr double kBlurDeviation = 60;  // mm
constexpr std::int64_t kScanSearchCellsMax = 4'000'000;
constexpr double kTurnStep = radians(0.4);

}  // namespace

ScanSearch::ScanSearch(std::span<const ScanPoint2d> others) {
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
  low_x_ -= kScanSearchMargin * kCell;
  low_y_ -= kScanSearchMargin * kCell;
  const double rows = std::floor((high_x - low_x_) / kCell) + 2 + kBlur;
  const double columns = std::floor((high_y - low_y_) / kCell) + 2 + kBlur;
  if (!(rows * columns < kScanSearchCellsMax)) return;
  rows_ = static_cast<std::int32_t>(rows);
  columns_ = static_cast<std::int32_t>(columns);
  levels_.resize(kLevels);
  levels_[0].resize(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_));
  for (const ScanPoint2d& p : others) draw(p);
  for (std::size_t level = 1; level < kLevels; ++level) widen(level);
}

void ScanSearch::draw(const ScanPoint2d& point) {
  const double x = (static_cast<double>(point.x) - low_x_) / kCell;
  const double y = (static_cast<double>(point.y) - low_y_) / kCell;
  const auto row = static_cast<std::int32_t>(x);
  const auto column = static_cast<std::int32_t>(y);
  for (std::int32_t r = row - kBlur; r <= row + kBlur; ++r)
    for (std::int32_t c = column - kBlur; c <= column + kBlur; ++c) {
      const double off = kCell * std::hypot(r + 0.5 - x, c + 0.5 - y) / kBlurDeviation;
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
};

std::uint32_t ScanSearch::sum(std::size_t level, std::span<const Offset> points, std::int32_t row,
                              std::int32_t column) const {
  const auto& cells = levels_[level];
  std::uint32_t all = 0;
  for (const Offset& p : points) {
    const std::int32_t r = p.row + row;
    const std::int32_t c = p.column + column;
    if (r < 0 || c < 0 || r >= rows_ || c >= columns_) continue;
    all += cells[cell(r, c)];
  }
  return all;
}

void ScanSearch::descend(const Turned& turned, std::size_t level, const Square& square,
                         std::uint32_t& best_sum, std::optional<Square>& best) const {
  if (square.sum <= best_sum) return;
  if (level == 0) {
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
      const Square part{row, column, sum(level - 1, turned.points, row, column)};
      for (; at > 0 && parts[at - 1].sum < part.sum; --at) parts[at] = parts[at - 1];
      parts[at] = part;
    }
  for (std::size_t i = 0; i < count; ++i) descend(turned, level - 1, parts[i], best_sum, best);
}

std::optional<ScanSearch::Found> ScanSearch::find(std::span<const ScanPoint2d> scan,
                                                  const Pose& middle, const Window& window,
                                                  double least) const {
  if (levels_.empty() || scan.empty()) return std::nullopt;
  auto best_sum = static_cast<std::uint32_t>(least * 255 * static_cast<double>(scan.size()));
  std::optional<Found> found;
  Turned turned{.shift_max = static_cast<std::int32_t>(std::ceil(window.distance / kCell))};
  const std::int32_t side = 1 << (kLevels - 1);
  const int turns = static_cast<int>(std::ceil(window.turn / kTurnStep));
  std::vector<Square> squares;
  for (int turn = -turns; turn <= turns; ++turn) {
    const double rho = middle.rho + turn * kTurnStep;
    const double c = std::cos(rho);
    const double s = std::sin(rho);
    turned.points.clear();
    for (const ScanPoint2d& p : scan) {
      const auto x = static_cast<double>(p.x);
      const auto y = static_cast<double>(p.y);
      const double row = (middle.x + c * x - s * y - low_x_) / kCell;
      const double column = (middle.y + s * x + c * y - low_y_) / kCell;
      if (std::abs(row) > 1e6 || std::abs(column) > 1e6) continue;
      turned.points.push_back({static_cast<std::int32_t>(std::floor(row)),
                               static_cast<std::int32_t>(std::floor(column))});
    }
    squares.clear();
    for (std::int32_t r = -turned.shift_max; r <= turned.shift_max; r += side)
      for (std::int32_t q = -turned.shift_max; q <= turned.shift_max; q += side)
        squares.push_back({r, q, sum(kLevels - 1, turned.points, r, q)});
    std::ranges::sort(squares, std::greater{}, &Square::sum);
    std::optional<Square> best;
    for (const Square& square : squares) descend(turned, kLevels - 1, square, best_sum, best);
    if (!best) continue;
    found = Found{{.x = middle.x + best->row * kCell,
                   .y = middle.y + best->column * kCell,
                   .rho = heading(rho)},
                  best_sum / (255.0 * static_cast<double>(scan.size()))};
  }
  return found;
}

}  // namespace rack::mapping

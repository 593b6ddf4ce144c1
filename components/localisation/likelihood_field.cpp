#include "components/localisation/likelihood_field.h"

#include <array>
#include <cmath>
#include <limits>

namespace rack::localisation {

namespace {

constexpr float kFar = 1e12F;  // cells squared: no obstacle
constexpr double kSigmas = 5;  // distances beyond this are treated as equal

// The lower envelope of the parabolas (x - i)^2 + f(i), evaluated at every x, in place.
class Envelope {
 public:
  explicit Envelope(std::size_t length) : values_(length), at_(length), from_(length + 1) {}

  void transform(float* f, std::size_t length, std::size_t step) {
    std::size_t last = 0;
    at_[0] = 0;
    from_[0] = -std::numeric_limits<float>::infinity();
    from_[1] = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < length; ++i) values_[i] = f[i * step];
    for (std::size_t i = 1; i < length; ++i) {
      float meets = crossing(i, at_[last]);
      while (last > 0 && meets <= from_[last]) meets = crossing(i, at_[--last]);
      ++last;
      at_[last] = i;
      from_[last] = meets;
      from_[last + 1] = std::numeric_limits<float>::infinity();
    }
    std::size_t k = 0;
    for (std::size_t i = 0; i < length; ++i) {
      while (from_[k + 1] < static_cast<float>(i)) ++k;
      const float away = static_cast<float>(i) - static_cast<float>(at_[k]);
      f[i * step] = std::min(away * away + values_[at_[k]], kFar);
    }
  }

 private:
  [[nodiscard]] float crossing(std::size_t a, std::size_t b) const {
    const auto x = static_cast<double>(a);
    const auto y = static_cast<double>(b);
    return static_cast<float>((values_[a] + x * x - values_[b] - y * y) / (2 * (x - y)));
  }

  std::vector<float> values_;
  std::vector<std::size_t> at_;  // index of the parabola that is the lowest
  std::vector<float> from_;      // from this x on
};

// Squared distances from the centres of cells to walls, in cells, up to `reach`.
class WallDistances {
 public:
  WallDistances(const GridMap& map, double reach, std::span<float> squares, std::size_t stride)
      : map_(map), reach_(reach / map.resolution), squares_(squares), stride_(stride) {}

  // In pieces: the bounding box of a long diagonal wall would be the whole map.
  void add(const MapLine& wall) {
    const double x = to_cells(wall.from.x, map_.origin.x);
    const double y = to_cells(wall.from.y, map_.origin.y);
    const double dx = (wall.to.x - wall.from.x) / map_.resolution;
    const double dy = (wall.to.y - wall.from.y) / map_.resolution;
    const double pieces = std::max(1.0, std::ceil(std::hypot(dx, dy) / (2 * reach_)));
    const auto count = static_cast<std::int64_t>(pieces);
    for (std::int64_t i = 0; i < count; ++i) {
      const double part = static_cast<double>(i) / pieces;
      add_piece(x + dx * part, y + dy * part, dx / pieces, dy / pieces);
    }
  }

 private:
  // 0 is the centre of the table's first cell, which is one cell before the map.
  [[nodiscard]] double to_cells(double at, double origin) const {
    return (at - origin) / map_.resolution + 0.5;
  }
  void add_piece(double x, double y, double dx, double dy) {
    const double length = dx * dx + dy * dy;
    const auto first = [&](double at, double extent) {
      return static_cast<std::size_t>(
          std::max(0.0, std::ceil(at + std::min(0.0, extent) - reach_)));
    };
    const auto last = [&](double at, double extent, std::size_t count) {
      return static_cast<std::size_t>(
          std::clamp(at + std::max(0.0, extent) + reach_, 0.0, static_cast<double>(count - 1)));
    };
    const std::size_t row_end = last(x, dx, squares_.size() / stride_);
    const std::size_t column_end = last(y, dy, stride_);
    for (std::size_t row = first(x, dx); row <= row_end; ++row)
      for (std::size_t column = first(y, dy); column <= column_end; ++column) {
        const double px = static_cast<double>(row) - x;
        const double py = static_cast<double>(column) - y;
        const double part = length > 0 ? std::clamp((px * dx + py * dy) / length, 0.0, 1.0) : 0;
        const double ox = px - part * dx;
        const double oy = py - part * dy;
        float& square = squares_[row * stride_ + column];
        square = std::min(square, static_cast<float>(ox * ox + oy * oy));
      }
  }

  const GridMap& map_;
  double reach_;  // cells
  std::span<float> squares_;
  std::size_t stride_;
};

// Squared distances from the centres of cells to the centres of occupied cells; those are 0.
void spread(std::vector<float>& squares, std::size_t rows, std::size_t columns) {
  Envelope envelope(std::max(rows, columns));
  for (std::size_t row = 0; row < rows; ++row)
    envelope.transform(&squares[row * columns], columns, 1);
  for (std::size_t column = 0; column < columns; ++column)
    envelope.transform(&squares[column], rows, columns);
}

}  // namespace

tims::Result<LikelihoodField> LikelihoodField::of(const GridMap& map,
                                                  const FieldSettings& settings) {
  const auto inner_rows = static_cast<std::size_t>(map.rows);
  const auto inner_columns = static_cast<std::size_t>(map.columns);
  const std::size_t rows = inner_rows + 2;
  const std::size_t columns = inner_columns + 2;
  LikelihoodField field;
  std::vector<float> squares(rows * columns, kFar);
  bool occupied = false;
  for (std::size_t row = 0; row < inner_rows; ++row)
    for (std::size_t column = 0; column < inner_columns; ++column) {
      const std::size_t at = (row + 1) * columns + column + 1;
      const Cell cell = map.cells[row * inner_columns + column];
      if (cell == Cell::kOccupied && map.walls.empty()) squares[at] = 0;
      if (cell == Cell::kFree) field.free_.push_back(static_cast<std::uint32_t>(at));
      occupied = occupied || cell == Cell::kOccupied;
    }
  if (!occupied) return tims::Error(tims::Errc::kMalformed, "the map has no occupied cell");
  if (field.free_.empty()) return tims::Error(tims::Errc::kMalformed, "the map has no free cell");
  if (map.walls.empty()) {
    spread(squares, rows, columns);
  } else {
    // Beyond this distance the table is 0.
    WallDistances distances(map, kSigmas * settings.sigma + map.resolution, squares, columns);
    for (const MapLine& wall : map.walls) distances.add(wall);
  }

  field.resolution_ = map.resolution;
  field.sigma_ = settings.sigma;
  field.hit_ = settings.hit;
  field.low_x_ = static_cast<float>(map.origin.x - map.resolution);
  field.low_y_ = static_cast<float>(map.origin.y - map.resolution);
  field.cells_per_mm_ = static_cast<float>(1 / map.resolution);
  field.row_max_ = static_cast<float>(rows - 1);
  field.column_max_ = static_cast<float>(columns - 1);
  field.stride_ = static_cast<std::int32_t>(columns);
  const double low = std::log(1 - settings.hit);
  field.log_ratio_ = static_cast<float>(-low);
  const double scale = map.resolution * map.resolution / (2 * settings.sigma * settings.sigma);
  const auto level = [&](double square) {
    const double p = settings.hit * std::exp(-scale * square) + 1 - settings.hit;
    return static_cast<std::uint8_t>(std::lround(255 * (1 - std::log(p) / low)));
  };
  field.wall_ = level(0.5);  // cells squared
  field.table_.reserve(squares.size());
  for (std::size_t at = 0; at < squares.size(); ++at) {
    const std::size_t row = at / columns;
    const std::size_t column = at % columns;
    const bool border = row == 0 || row + 1 == rows || column == 0 || column + 1 == columns;
    field.table_.push_back(border ? 0 : level(squares[at]));
  }
  return field;
}

// First computes the indices of all end points, then reads the table. The first loop processes four
// beams at once; therefore it has no branch, no integer multiplication (a float is exact up to 2^24
// cells; larger maps need one), and uses arrays. max(0, x) is 0 when x is not a number.
template <bool kIsHuge>
std::uint32_t LikelihoodField::sum_of(float x, float y, float sine, float cosine,
                                      const Beams& beams) const {
  constexpr std::size_t kAtOnce = 64;
  std::array<std::int32_t, kAtOnce> cells;  // NOLINT(cppcoreguidelines-pro-type-member-init)
  const float row = (x - low_x_) * cells_per_mm_;
  const float column = (y - low_y_) * cells_per_mm_;
  const float c = cosine * cells_per_mm_;
  const float s = sine * cells_per_mm_;
  const float row_max = row_max_;
  const float column_max = column_max_;
  [[maybe_unused]] const auto stride = static_cast<float>(stride_);
  std::uint32_t all = 0;
  for (std::size_t begin = 0; begin < beams.size(); begin += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, beams.size() - begin);
    const float* const bx = beams.x() + begin;
    const float* const by = beams.y() + begin;
    for (std::size_t i = 0; i < count; ++i) {
      const float r = std::min(std::max(0.0F, row + c * bx[i] - s * by[i]), row_max);
      const float q = std::min(std::max(0.0F, column + s * bx[i] + c * by[i]), column_max);
      if constexpr (kIsHuge)
        cells[i] = static_cast<std::int32_t>(r) * stride_ + static_cast<std::int32_t>(q);
      else
        cells[i] =
            static_cast<std::int32_t>(static_cast<float>(static_cast<std::int32_t>(r)) * stride +
                                      static_cast<float>(static_cast<std::int32_t>(q)));
    }
    for (std::size_t i = 0; i < count; ++i) all += table_[static_cast<std::size_t>(cells[i])];
  }
  return all;
}

std::uint32_t LikelihoodField::sum(float x, float y, float sine, float cosine,
                                   const Beams& beams) const {
  constexpr std::size_t kExact = 1U << 24U;
  return table_.size() <= kExact ? sum_of<false>(x, y, sine, cosine, beams)
                                 : sum_of<true>(x, y, sine, cosine, beams);
}

double LikelihoodField::fit(const Pose& pose, const Beams& beams) const {
  if (beams.empty()) return 0;
  const std::uint32_t all =
      sum(static_cast<float>(pose.x), static_cast<float>(pose.y),
          static_cast<float>(std::sin(pose.rho)), static_cast<float>(std::cos(pose.rho)), beams);
  return all / (255.0 * static_cast<double>(beams.size()));
}

// The last kAtEnd of a beam is not checked: at a low angle of incidence, the range to a wall
// varies.
bool LikelihoodField::is_blocked(const Pose& from, const MapPoint& end) const {
  constexpr double kAtEnd = 500;  // mm
  const double x = end.x - from.x;
  const double y = end.y - from.y;
  const double length = std::hypot(x, y);
  const auto per_mm = static_cast<double>(cells_per_mm_);
  const auto across = static_cast<double>(row_max_ + column_max_);  // beyond, outside of the map
  const auto cells =
      static_cast<std::size_t>(std::clamp(std::ceil((length - kAtEnd) * per_mm), 0.0, across));
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const double part = static_cast<double>(cell) / (length * per_mm);
    const auto at_x = static_cast<float>(from.x + part * x);
    const auto at_y = static_cast<float>(from.y + part * y);
    if (at(at_x, at_y) >= wall_) return true;
  }
  return false;
}

double LikelihoodField::blocked(const Pose& pose, const Beams& beams) const {
  constexpr double kFits = 300;  // mm from a wall
  std::size_t count = 0;
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const Pose end =
        pose + Pose{.x = static_cast<double>(beams[i].x), .y = static_cast<double>(beams[i].y)};
    if (distance(end.x, end.y) < kFits) continue;
    count += is_blocked(pose, {end.x, end.y}) ? 1U : 0U;
  }
  return beams.empty() ? 0 : static_cast<double>(count) / static_cast<double>(beams.size());
}

double LikelihoodField::distance(double x, double y) const {
  const double p =
      std::exp((1 - at(static_cast<float>(x), static_cast<float>(y)) / 255.0) * std::log(1 - hit_));
  const double likely = std::max((p - 1 + hit_) / hit_, 1e-9);
  return sigma_ * std::sqrt(-2 * std::log(std::min(likely, 1.0)));
}

bool LikelihoodField::is_free(double x, double y) const {
  const auto at = static_cast<std::uint32_t>(index(static_cast<float>(x), static_cast<float>(y)));
  return std::ranges::binary_search(free_, at);
}

MapPoint LikelihoodField::draw_free(Random& random) const {
  const auto cell =
      static_cast<std::int32_t>(free_[random.below(static_cast<std::uint32_t>(free_.size()))]);
  const auto place = [&](float low, std::int32_t at) {
    return static_cast<double>(low) + (at + static_cast<double>(random.uniform())) * resolution_;
  };
  const double x = place(low_x_, cell / stride_);
  return {x, place(low_y_, cell % stride_)};
}

}  // namespace rack::localisation

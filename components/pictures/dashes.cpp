#include "components/pictures/dashes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/text.h"

namespace rack::pictures {
namespace {

constexpr double kSegmentMax =
    1e7;  // pixels; a dash is then still much longer than a rounding error

struct Part {
  double begin = 0;
  double end = 1;
};

// Liang and Barsky: which part of a segment is in the box, as fractions of its length.
Part part_inside(const Spot& from, const Spot& to, const Box& box) {
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  const std::array<std::array<double, 2>, 4> sides = {{{-dx, from.x - box.x},
                                                       {dx, box.x + box.width - from.x},
                                                       {-dy, from.y - box.y},
                                                       {dy, box.y + box.height - from.y}}};
  Part part;
  for (const auto& [speed, distance] : sides) {
    if (speed == 0 && distance < 0) return {1, 0};
    if (speed < 0) part.begin = std::max(part.begin, distance / speed);
    if (speed > 0) part.end = std::min(part.end, distance / speed);
  }
  return part;
}

class Dasher {
 public:
  explicit Dasher(std::span<const double> lengths)
      : lengths_(lengths), whole_(std::accumulate(lengths.begin(), lengths.end(), 0.0)) {}

  void segment(const Spot& from, const Spot& to, const Box& box) {
    const double length = std::hypot(to.x - from.x, to.y - from.y);
    if (!(length > 0 && length < kSegmentMax)) return;
    const Part part = part_inside(from, to, box);
    if (!(part.begin < part.end)) {
      end_dash();
      travelled_ = std::fmod(travelled_ + length, whole_);
      return;
    }
    const auto at = [&](double distance) {
      const double t = distance / length;
      return Spot{from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)};
    };
    double distance = part.begin * length;
    if (part.begin > 0) end_dash();
    seek(travelled_ + distance);
    for (const double end = part.end * length; distance < end;) {
      const double step = std::min(left_, end - distance);
      if (index_ % 2 == 0) {
        if (dash_.empty()) dash_.push_back(at(distance));
        dash_.push_back(at(distance + step));
      }
      distance += step;
      left_ -= step;
      if (left_ > 0) continue;
      end_dash();
      index_ = (index_ + 1) % lengths_.size();
      left_ = lengths_[index_];
    }
    if (part.end < 1) end_dash();
    travelled_ = std::fmod(travelled_ + length, whole_);
  }

  std::vector<std::vector<Spot>> finish() && {
    end_dash();
    return std::move(dashes_);
  }

 private:
  // The dash or gap at a distance from the beginning of the line.
  void seek(double distance) {
    left_ = std::fmod(distance, whole_);
    for (index_ = 0; index_ + 1 < lengths_.size() && left_ >= lengths_[index_]; ++index_)
      left_ -= lengths_[index_];
    left_ = std::max(lengths_[index_] - left_, 0.0);
  }
  void end_dash() {
    if (!dash_.empty()) dashes_.push_back(std::move(dash_));
    dash_.clear();
  }

  std::span<const double> lengths_;
  double whole_;
  double travelled_ = 0;   // of the whole pattern, at the beginning of the segment
  std::size_t index_ = 0;  // an even one is a dash
  double left_ = 0;        // of it
  std::vector<Spot> dash_;
  std::vector<std::vector<Spot>> dashes_;
};

}  // namespace

std::vector<double> dash_lengths(std::string_view dashes) {
  constexpr double kShortest = 0.5;  // pixels
  std::vector<double> lengths;
  while (!dashes.empty()) {
    const std::string_view token = dashes.substr(0, dashes.find(' '));
    dashes.remove_prefix(std::min(token.size() + 1, dashes.size()));
    const auto length = tims::base::parse_number<double>(token);
    if (!length || !(*length >= kShortest) || !std::isfinite(*length)) return {};
    lengths.push_back(*length);
  }
  if (lengths.size() % 2 == 1) {
    const std::vector<double> once = lengths;
    lengths.insert(lengths.end(), once.begin(), once.end());
  }
  return lengths;
}

std::vector<std::vector<Spot>> dashes_of(std::span<const Spot> line, std::span<const double> dashes,
                                         const Box& box) {
  if (dashes.empty()) return {};
  Dasher dasher(dashes);
  for (std::size_t i = 1; i < line.size(); ++i) dasher.segment(line[i - 1], line[i], box);
  return std::move(dasher).finish();
}

}  // namespace rack::pictures

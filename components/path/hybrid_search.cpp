#include "components/path/hybrid_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace rack::path {

namespace {

constexpr std::size_t kHeadings = 72;
constexpr double kBinsMax = 120;    // per direction
constexpr double kBinMin = 250;     // mm
constexpr double kStepOfBin = 1.5;  // long enough to leave the bin
constexpr std::size_t kNodesMax = 120000;
constexpr std::size_t kPiecesMax = 4000;
constexpr double kOfTheRoom = 0.6;   // the ends of the hull move farther than its centre
constexpr double kCheckEvery = 100;  // mm
constexpr double kBesideTheStart =
    1500;  // mm: within this distance, the clearance of the start is enough
constexpr double kHybridSearchCellsMax = 160;  // of the estimate, per direction
constexpr double kTurning = 1.05;              // cost factor of arcs
constexpr double kNearRadii = 3;               // within these radii of the goal the heading counts
constexpr double kShortestTry = 4;  // minimum number of poses between two tries of the direct path

}  // namespace

HybridSearch::HybridSearch() {
  to_goal_.reserve(static_cast<std::size_t>(kHybridSearchCellsMax * kHybridSearchCellsMax * 1.1));
  bins_.reserve(static_cast<std::size_t>(kBinsMax * kBinsMax) * kHeadings);
  nodes_.reserve(kNodesMax);
  open_.reserve(2 * kNodesMax);
  pieces_.reserve(kPiecesMax);
  shorter_.reserve(kPiecesMax);
}

void HybridSearch::begin(const FreeSpace& space, const Settings& settings, const Pose& start,
                         const Pose& goal) {
  space_ = &space;
  settings_ = settings;
  start_ = start;
  goal_ = goal;
  start_room_ = std::min(0.0, space.room(settings.hull, start));
  const double width = space.cell() * static_cast<double>(std::max(space.rows(), space.columns()));
  bin_ = std::max(kBinMin, width / kBinsMax);
  rows_ = static_cast<std::size_t>(space.cell() * static_cast<double>(space.rows()) / bin_) + 1;
  columns_ =
      static_cast<std::size_t>(space.cell() * static_cast<double>(space.columns()) / bin_) + 1;
  bins_.assign(rows_ * columns_ * kHeadings, -1);
  nodes_.clear();
  open_.clear();
  pieces_.clear();
  closed_ = 0;
  until_try_ = 0;
  // An estimate: it may pass where the car has no room, but not through walls.
  const auto stride =
      static_cast<std::size_t>(std::ceil(width / space.cell() / kHybridSearchCellsMax));
  to_goal_.run(space,
               {.room = settings.hull.half_width() / 2, .stride = std::max<std::size_t>(1, stride)},
               {goal.x, goal.y}, nullptr);
  Node first;
  first.at = start;
  open(first);
}

HybridSearch::Progress HybridSearch::advance(int poses) {
  for (; poses > 0; --poses) {
    std::int32_t best = -1;
    while (!open_.empty() && best < 0) {
      std::pop_heap(open_.begin(), open_.end());
      best = open_.back().node;
      open_.pop_back();
      if (nodes_[static_cast<std::size_t>(best)].closed) best = -1;
    }
    if (best < 0 || nodes_.size() + 8 > kNodesMax) return Progress::kFailed;
    nodes_[static_cast<std::size_t>(best)].closed = true;
    ++closed_;
    if (--until_try_ <= 0 && try_the_rest(best)) return Progress::kFound;
    look_around(best);
  }
  return Progress::kSearching;
}

std::size_t HybridSearch::bin_of(const Pose& at) const {
  const auto part = [&](double place, double corner, std::size_t count) {
    return static_cast<std::size_t>(
        std::clamp((place - corner) / bin_, 0.0, static_cast<double>(count) - 0.5));
  };
  const auto turn = static_cast<std::size_t>(heading(at.rho) / (2 * kPi) * kHeadings);
  return (part(at.x, space_->corner().x, rows_) * columns_ +
          part(at.y, space_->corner().y, columns_)) *
             kHeadings +
         std::min(turn, kHeadings - 1);
}

// The cost of a piece that follows another one.
double HybridSearch::cost_of(const Piece& piece, const Piece& before) const {
  double cost = std::abs(piece.length) * (piece.length < 0 ? settings_.backward : 1);
  if (piece.curvature != 0) cost *= kTurning;
  if (before.length * piece.length < 0) cost += settings_.change;
  return cost;
}

double HybridSearch::price(std::span<const Piece> pieces) const {
  double cost = 0;
  Piece before;
  for (const Piece& piece : pieces) {
    cost += cost_of(piece, before);
    before = piece;
  }
  return cost;
}

void HybridSearch::open(const Node& node) {
  const double left = to_goal_.cost({node.at.x, node.at.y});
  if (!std::isfinite(left)) return;
  std::int32_t& in_bin = bins_[bin_of(node.at)];
  if (in_bin >= 0) {
    const Node& there = nodes_[static_cast<std::size_t>(in_bin)];
    if (there.closed || there.cost <= node.cost) return;
    nodes_[static_cast<std::size_t>(in_bin)].closed = true;
  }
  in_bin = static_cast<std::int32_t>(nodes_.size());
  nodes_.push_back(node);
  const double least = std::min(1.0, settings_.backward);
  double estimate = left;
  if (left < kNearRadii * settings_.radius)
    estimate = std::max(left, ReedsShepp(node.at, goal_, settings_.radius).length());
  open_.push_back({node.cost + least * estimate, in_bin});
  std::push_heap(open_.begin(), open_.end());
}

void HybridSearch::look_around(std::int32_t index) {
  const Node from = nodes_[static_cast<std::size_t>(index)];
  const double step = kStepOfBin * bin_;
  for (const double sense : {1.0, -1.0}) {
    for (const double side : {0.0, 1.0, -1.0}) {
      const Piece piece{side / settings_.radius, sense * step};
      if (!is_free(from.at, {&piece, 1})) continue;
      Node next;
      next.at = driven(from.at, piece);
      next.cost = from.cost + cost_of(piece, from.by);
      next.parent = index;
      next.by = piece;
      open(next);
    }
  }
}

// Tries the direct path to the goal; more often near the goal.
bool HybridSearch::try_the_rest(std::int32_t index) {
  const Node& node = nodes_[static_cast<std::size_t>(index)];
  const double left = to_goal_.cost({node.at.x, node.at.y});
  until_try_ = static_cast<int>(std::clamp(left / (4 * bin_), kShortestTry, 40.0));
  const ReedsShepp rest(node.at, goal_, settings_.radius);
  // A direct path that is much longer than the path over the cells leads around something else.
  if (rest.length() > 1.5 * left + 6 * settings_.radius || !is_free(node.at, rest.pieces()))
    return false;
  finish(index, rest.pieces());
  return true;
}

void HybridSearch::finish(std::int32_t index, std::span<const Piece> rest) {
  pieces_.clear();
  for (std::int32_t i = index; i > 0; i = nodes_[static_cast<std::size_t>(i)].parent)
    pieces_.push_back(nodes_[static_cast<std::size_t>(i)].by);
  std::reverse(pieces_.begin(), pieces_.end());
  pieces_.insert(pieces_.end(), rest.begin(), rest.end());
  shorten();
  merge();
}

// Replaces parts of the path: from each pose, by a cheaper free path to the latest possible pose.
void HybridSearch::shorten() {
  shorter_.clear();
  Pose at = start_;
  std::size_t i = 0;
  while (i < pieces_.size()) {
    std::array<Pose, 64> poses;
    const std::size_t ahead = std::min(pieces_.size() - i, poses.size() - 1);
    poses[0] = at;
    for (std::size_t k = 0; k < ahead; ++k) poses[k + 1] = driven(poses[k], pieces_[i + k]);
    std::size_t taken = 1;
    for (std::size_t k = ahead; k > 1; k = k > 8 ? k - 3 : k - 1) {
      const std::span<const Piece> old(&pieces_[i], k);
      const ReedsShepp shortcut(at, poses[k], settings_.radius);
      if (price(shortcut.pieces()) >= price(old) || !is_free(at, shortcut.pieces())) continue;
      shorter_.insert(shorter_.end(), shortcut.pieces().begin(), shortcut.pieces().end());
      taken = k;
      break;
    }
    if (taken == 1) shorter_.push_back(pieces_[i]);
    at = poses[taken];
    i += taken;
  }
  pieces_ = shorter_;
}

// Joins neighbouring pieces of equal curvature.
void HybridSearch::merge() {
  std::size_t count = 0;
  for (const Piece& piece : pieces_) {
    if (std::abs(piece.length) < 1) continue;
    Piece* last = count == 0 ? nullptr : &pieces_[count - 1];
    if (last != nullptr && last->curvature == piece.curvature && last->length * piece.length > 0)
      last->length += piece.length;
    else
      pieces_[count++] = piece;
  }
  pieces_.resize(count);
}

// --- room

double HybridSearch::room(const Pose& at) const {
  const double room = space_->room(settings_.hull, at);
  if (room >= 0 || room < start_room_) return room;
  return std::hypot(at.x - start_.x, at.y - start_.y) < kBesideTheStart ? 0 : room;
}

// With much clearance the next sample may be far away.
bool HybridSearch::is_free(const Pose& from, std::span<const Piece> pieces) const {
  Pose at = from;
  for (const Piece& piece : pieces) {
    const double length = std::abs(piece.length);
    for (double distance = 0; distance < length;) {
      const double here = room(driven(at, {piece.curvature, piece.length * distance / length}));
      if (here < 0) return false;
      distance += std::max(kCheckEvery, kOfTheRoom * here);
    }
    at = driven(at, piece);
    if (room(at) < 0) return false;
  }
  return true;
}

}  // namespace rack::path

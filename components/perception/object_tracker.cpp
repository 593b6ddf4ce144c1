#include "components/perception/object_tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rack::perception {
namespace {

constexpr double kGate = 9.21;        // squared Mahalanobis distance: 99 % for 2 degrees of freedom
constexpr double kGateMost = 1000;    // mm
constexpr double kStride = 650;       // mm between the legs of a person
constexpr double kOwnRoom = 350;      // mm: no new object starts this near to a person
constexpr double kSame = 200;         // mm: objects nearer than this are one
constexpr double kLegsOfOne = 450;    // mm
constexpr double kAlike = 800;        // mm/s
constexpr double kUnsureBehind = 4;   // factor on the distance: new objects after confirmed ones
constexpr double kUnmovedBehind = 2;  // the same: the room after moved points
constexpr double kMoved = 0.5;        // share of a cluster's points
constexpr double kForgottenAfter =
    30;  // s without motion, without a map: then it is part of the room
constexpr double kNeverMovedAfter = 5;  // s, the same for an object that was never moving
constexpr double kBodyHalf = 200;       // mm, half as wide as people are
constexpr double kBoxWithin = 0.7;      // of its size: range of its visible centre

constexpr double kOneLeg = 130;  // mm, standard deviation of a person's centre
constexpr double kTwoLegs = 60;
constexpr double kBody = 80;
constexpr double kBoxLeast = 100;
constexpr double kBoxPart = 0.1;  // of its size

double deviation_of(const Cluster& cluster) {
  const double beams = cluster.spacing / 2;
  if (cluster.leg) return std::hypot(kOneLeg, beams);
  if (cluster.person) return std::hypot(kBody, beams);
  return std::hypot(std::max(kBoxLeast, kBoxPart * cluster.size), beams);
}

}  // namespace

ObjectTracker::ObjectTracker(const TrackerSettings& settings) : settings_(settings) {
  tracks_.reserve(kTracksMax);
  parts_.reserve(kTracksMax);
  pairs_.reserve(kPairsMax);
  taken_.reserve(ClusterFinder::kClustersMax);
  doomed_.reserve(kTracksMax);
}

void ObjectTracker::forget() { tracks_.clear(); }

bool ObjectTracker::stop(std::int32_t id) {
  return std::erase_if(tracks_, [&](const Track& track) { return track.id() == id; }) > 0;
}

void ObjectTracker::take(std::span<const Cluster> clusters, const MapPoint& scanner,
                         const FreeTable& now, double seconds) {
  clusters_ = clusters.first(std::min(clusters.size(), ClusterFinder::kClustersMax));
  scanner_ = scanner;
  taken_.assign(clusters_.size(), false);
  parts_.assign(tracks_.size(), {});
  for (Track& track : tracks_) track.predict(seconds);
  find_pairs();
  assign();
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (parts_[i].count == 0) {
      tracks_[i].miss(now.look(tracks_[i].at(), kBodyHalf) == FreeTable::Seen::kThrough);
      continue;
    }
    tracks_[i].look_back(now);
    tracks_[i].update(sighting(parts_[i]));
  }
  begin_tracks(seconds);
  drop();
  clusters_ = {};
}

void ObjectTracker::find_pairs() {
  pairs_.clear();
  for (std::uint32_t t = 0; t < tracks_.size(); ++t) {
    const Track& track = tracks_[t];
    const double reach = std::max(kGateMost, kBoxWithin * std::max(track.length(), track.width()));
    for (std::uint32_t c = 0; c < clusters_.size(); ++c) {
      const Cluster& cluster = clusters_[c];
      if (track.person() && !cluster.person) continue;
      if (settings_.only_moved && track.is_other(cluster)) continue;
      if (distance(track.at(), cluster.box.centre) > reach) continue;
      double far = track.mahalanobis(cluster, deviation_of(cluster));
      if (far > kGate) continue;
      if (!track.confirmed()) far += kUnsureBehind;
      if (cluster.moved < kMoved) far += kUnmovedBehind;
      if (pairs_.size() == kPairsMax) return;
      pairs_.push_back({.distance = far, .track = t, .cluster = c});
    }
  }
}

void ObjectTracker::assign() {
  std::ranges::sort(pairs_, [](const Pair& a, const Pair& b) {
    if (a.distance != b.distance) return a.distance < b.distance;
    return a.track != b.track ? a.track < b.track : a.cluster < b.cluster;
  });
  for (const Pair& pair : pairs_) {
    Part& part = parts_[pair.track];
    if (taken_[pair.cluster] || !joins(part, pair.cluster)) continue;
    taken_[pair.cluster] = true;
    (part.count == 0 ? part.first : part.second) = pair.cluster;
    ++part.count;
  }
}

bool ObjectTracker::joins(const Part& part, std::uint32_t cluster) const {
  if (part.count == 0) return true;
  const Cluster& one = clusters_[part.first];
  const Cluster& other = clusters_[cluster];
  return part.count == 1 && one.leg && other.leg &&
         distance(one.box.centre, other.box.centre) <= kStride;
}

Sighting ObjectTracker::sighting(const Part& part) const {
  const Cluster& one = clusters_[part.first];
  Sighting seen{.box = one.box,
                .deviation = deviation_of(one),
                .moved = one.moved,
                .person = one.person,
                .leg = one.leg,
                .point = one.point,
                .scanner = scanner_};
  if (part.count < 2) return seen;
  const Cluster& other = clusters_[part.second];
  const MapPoint a = one.box.centre;
  const MapPoint b = other.box.centre;
  seen.box.centre = {(a.x + b.x) / 2, (a.y + b.y) / 2};
  seen.box.length = distance(a, b) + std::max(one.size, other.size);
  seen.box.width = std::max(one.size, other.size);
  seen.deviation = std::hypot(kTwoLegs, one.spacing / 2);
  seen.moved = std::max(one.moved, other.moved);
  seen.pair = true;
  return seen;
}

bool ObjectTracker::may_begin(const Cluster& cluster) const {
  if (settings_.only_moved && cluster.moved < kMoved) return false;
  if (!cluster.person) return true;
  return std::ranges::none_of(tracks_, [&](const Track& track) {
    return track.person() && track.confirmed() &&
           distance(track.at(), cluster.box.centre) < kOwnRoom;
  });
}

// A leg is paired with the nearest other one.
void ObjectTracker::begin_tracks(double seconds) {
  for (std::uint32_t c = 0; c < clusters_.size(); ++c) {
    if (taken_[c] || tracks_.size() == kTracksMax || !may_begin(clusters_[c])) continue;
    Part part{.first = c, .count = 1};
    double nearest = kStride;
    for (std::uint32_t d = c + 1; clusters_[c].leg && d < clusters_.size(); ++d) {
      const double away = distance(clusters_[c].box.centre, clusters_[d].box.centre);
      if (taken_[d] || !clusters_[d].leg || away > nearest) continue;
      nearest = away;
      part.second = d;
      part.count = 2;
    }
    taken_[c] = true;
    if (part.count == 2) taken_[part.second] = true;
    tracks_.emplace_back(next_id_, sighting(part), seconds);
    next_id_ = next_id_ == std::numeric_limits<std::int32_t>::max() ? 1 : next_id_ + 1;
  }
}

bool ObjectTracker::are_one(const Track& a, const Track& b) {
  if (a.person() != b.person()) return false;
  const double apart = distance(a.at(), b.at());
  // Both are legs of the same person.
  const bool legs = a.person() && a.one_leg() && b.one_leg();
  return apart < kSame ||
         (legs && apart < kLegsOfOne && distance(a.velocity(), b.velocity()) < kAlike);
}

bool ObjectTracker::is_room(const Track& track) const {
  const double after = track.ever_moved() ? kForgottenAfter : kNeverMovedAfter;
  return settings_.only_moved && track.unmoved() > after;
}

void ObjectTracker::drop() {
  doomed_.assign(tracks_.size(), false);
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const Track& track = tracks_[i];
    // When two objects have merged, the older one stays.
    const auto older = [&](const Track& other) {
      return other.id() < track.id() && other.seen_now() && are_one(other, track);
    };
    doomed_[i] = track.lost() || is_room(track) || std::ranges::any_of(tracks_, older);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i)
    if (!doomed_[i]) tracks_[kept++] = tracks_[i];
  while (tracks_.size() > kept) tracks_.pop_back();
}

}  // namespace rack::perception

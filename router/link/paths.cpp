#include "router/link/paths.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace tims::link {
namespace {

// Interval of challenges to an address known only as the source of datagrams.
constexpr Duration kSuspectEvery = std::chrono::milliseconds(100);

std::string seconds_text(Duration time) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
  return ms < 10'000 ? std::to_string(ms) + " ms" : std::to_string(ms / 1000) + " s";
}

}  // namespace

std::size_t PathMtu::probe(Time now, std::size_t most) const {
  return now >= next_probe(most) ? kSteps[step_] : 0;
}

void PathMtu::on_probe_sent(std::size_t) { probing_ = true; }

void PathMtu::on_probe_acked(Time now, std::size_t size) {
  probing_ = false;
  tries_ = 0;
  lost_in_a_row_ = 0;
  if (size > size_) size_ = size;
  while (step_ < kSteps.size() && kSteps[step_] <= size_) ++step_;
  next_ = step_ < kSteps.size() ? now + kBetween : kNever;
}

void PathMtu::on_probe_lost(Time now) {
  probing_ = false;
  next_ = now + kBetween;
  if (++tries_ < kTries) return;
  // Larger sizes would fail too. Try again later.
  tries_ = 0;
  next_ = now + kTryAgain;
  if (size_ >= kDatagramBase) return;
  next_ = now + try_small_again_;
  try_small_again_ = std::min(2 * try_small_again_, kTryAgain);
}

void PathMtu::on_acked(std::size_t datagram, Time sent) {
  if (datagram <= floor()) return;
  lost_in_a_row_ = 0;
  counts_since_ = std::max(counts_since_, sent);
}

// One that was sent before a large one that has arrived was lost for another reason: in an outage.
bool PathMtu::on_lost(Time now, std::size_t datagram, Time sent) {
  if (datagram <= floor() || size_ == kDatagramMin || fixed_) return false;
  if (sent < counts_since_ || ++lost_in_a_row_ < kBlackHole) return false;
  restart(now, floor());
  return true;
}

void PathMtu::fix(std::size_t size) {
  *this = PathMtu();
  size_ = size;
  step_ = kSteps.size();
  fixed_ = true;
}

void PathMtu::reset(Time now) { restart(now, kDatagramBase); }

void PathMtu::restart(Time now, std::size_t size) {
  const Duration again = try_small_again_;
  *this = PathMtu();
  size_ = size;
  counts_since_ = now;
  if (size < kDatagramBase) {
    step_ = 0;
    try_small_again_ = again;
  }
  next_ = now + kBetween;
}

bool Path::is_target(const NetAddress& where) const {
  return std::ranges::find(targets, where) != targets.end();
}

// --- configuration

bool Paths::configure(Time now, std::span<const PathKind> preference, Duration keep_alive) {
  keep_alive_ = keep_alive;
  const PathKind used_kind = kind();
  std::vector<Path> paths;
  for (const PathKind kind : preference) {
    Path* old = mine(kind);
    paths.push_back(old == nullptr ? Path{.kind = kind} : std::move(*old));
  }
  if (paths.empty()) return false;
  paths_ = std::move(paths);
  const Path* still = find(used_kind);
  used_ = still == nullptr ? 0 : static_cast<std::size_t>(still - paths_.data());
  if (still != nullptr) return false;
  use(now, used_, std::string(name(used_kind)) + " is no longer configured");
  return true;
}

const Path* Paths::find(PathKind kind) const {
  const auto found = std::ranges::find(paths_, kind, &Path::kind);
  return found == paths_.end() ? nullptr : &*found;
}
Path* Paths::mine(PathKind kind) { return const_cast<Path*>(std::as_const(*this).find(kind)); }

void Paths::set_targets(PathKind kind, std::span<const NetAddress> targets) {
  Path* path = mine(kind);
  if (path == nullptr) return;
  path->targets.clear();
  for (const NetAddress& target : targets) {
    if (!path->is_target(target)) path->targets.push_back(target);
  }
}

bool Paths::has_targets() const {
  return std::ranges::any_of(paths_, [](const Path& path) { return !path.targets.empty(); });
}

bool Paths::is_target(const NetAddress& address) const {
  return std::ranges::any_of(paths_, [&](const Path& path) { return path.is_target(address); });
}

bool Paths::is_at(const NetAddress& address) const {
  return std::ranges::find(paths_, address, &Path::address) != paths_.end();
}

bool Paths::leads(PathKind kind) const {
  const Path* path = find(kind);
  return path != nullptr && (path->address || !path->targets.empty());
}

// The possible addresses of the other router on this path: the confirmed one, or else all
// candidates.
std::vector<NetAddress> Paths::places(const Path& path) {
  if (path.works) return {path.address};
  std::vector<NetAddress> all = path.targets;
  if (path.address && !path.is_target(path.address)) all.push_back(path.address);
  return all;
}

std::vector<NetAddress> Paths::to_call(bool first) const {
  std::vector<NetAddress> all;
  const auto add = [&](const NetAddress& to) {
    if (to && std::ranges::find(all, to) == all.end()) all.push_back(to);
  };
  for (const Path& path : paths_) {
    std::ranges::for_each(path.targets, add);
    if (suspected_ && suspected_.kind == path.kind) add(suspected_);
    if (first && !all.empty()) break;
  }
  return all;
}

// --- choice of the path in use

void Paths::use(Time now, std::size_t index, std::string why) {
  used_ = index;
  since_ = now;
  why_ = std::move(why);
}

void Paths::begin(Time now, const NetAddress& address) {
  suspected_ = {};
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    Path& path = paths_[i];
    path.works = path.kind == address.kind;
    // The previous address may belong to another router.
    path.address = path.works ? address : NetAddress();
    path.since = now;
    path.asked = path.works ? now : Time{};
    if (!path.works) continue;
    path.answered = now;
    use(now, i, "the link came up over it");
  }
}

bool Paths::on_called(Time now, const NetAddress& from, bool proven) {
  Path* path = mine(from.kind);
  if (path == nullptr || path->works) return false;
  path->address = from;
  path->asked = {};
  if (!proven) return false;
  path->works = true;
  path->since = path->answered = now;
  return choose(now);
}

bool Paths::is_strange(const NetAddress& from) const {
  const Path* path = find(from.kind);
  return path == nullptr || (path != &used() && !path->works);
}

void Paths::begin_again(Time now) {
  for (Path& path : paths_) {
    path.works = false;
    path.since = now;
    path.asked = {};
  }
  use(now, used_, "the link receives again");
}

void Paths::fail(Time now, Path& path) {
  path.works = false;
  path.since = now;
  if (&path != &used()) return;
  const bool again =
      path.failed != Time{} && now < path.failed + path.probation + Path::kProbationMax;
  path.probation = again ? std::min(2 * path.probation, Path::kProbationMax) : Path::kProbation;
  path.failed = now;
}

bool Paths::choose(Time now) {
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    const Path& path = paths_[i];
    if (!path.works) continue;
    if (i == used_) return false;
    const bool better = i < used_;
    // Taken back only on an answer, so that the next one is not already overdue.
    const bool proven = now >= path.since + path.probation && now == path.answered;
    if (better && used().works && !proven) continue;
    const std::string left(name(kind()));
    use(now, i,
        used().works
            ? std::string(name(path.kind)) + " has worked for " + seconds_text(now - path.since)
            : left + " has not answered for " + seconds_text(now - used().answered));
    return true;
  }
  return false;
}

// --- challenges

Paths::Question Paths::note(const Question& question, bool known) {
  asked_[next_asked_] = {question, known};
  next_asked_ = (next_asked_ + 1) % asked_.size();
  return question;
}

std::optional<Paths::Question> Paths::on_source(Time now, const NetAddress& from,
                                                std::uint64_t random) {
  const Path* path = find(from.kind);
  if (path == nullptr || path->address == from) return std::nullopt;
  if (suspected_ == from && now < suspected_at_ + kSuspectEvery) return std::nullopt;
  suspected_ = from;
  suspected_at_ = now;
  return note({from, random}, false);
}

// A repeated answer from a third party must not redirect the link: from an address that is known
// only as the source of a datagram, the answer itself must arrive.
bool Paths::on_answer(Time now, const NetAddress& from, std::uint64_t nonce) {
  const auto asked = std::ranges::find_if(asked_, [&](const Asked& a) {
    return a.question.to && a.question.nonce == nonce && (a.known || a.question.to == from);
  });
  if (asked == asked_.end()) return false;
  const bool known = asked->known;
  const NetAddress where = std::exchange(asked->question.to, {});
  if (suspected_ == where) suspected_ = {};
  Path* path = mine(where.kind);
  if (path == nullptr) return false;
  // Of several challenged addresses, the first to answer is the nearest.
  if (known && path->works && path->address != where) return false;
  path->answered = now;
  if (!path->works) {
    path->works = true;
    path->since = now;
  }
  const bool moved = std::exchange(path->address, where) != where && path == &used();
  if (!choose(now)) return moved;
  return true;
}

bool Paths::on_gone(Time now, const NetAddress& where) {
  Path* path = mine(where.kind);
  if (path == nullptr || path->address != where || !path->works) return false;
  path->works = false;
  path->since = now;
  return choose(now);
}

Duration Paths::interval(const Path& path) const {
  const bool being_taken_back = path.works && &path < &used();
  return &path == &used() || being_taken_back ? keep_alive_ : std::max(keep_alive_, kStandbyEvery);
}

// A standby path is not dead merely because it is challenged less often.
Time Paths::alive_at(const Path& path) const {
  return &path == &used() ? std::max(path.answered, since_) : path.answered;
}

Time Paths::next_question(const Path& path, Duration rtt) const {
  if (!path.address && path.targets.empty()) return kNever;
  const Time next = path.asked + interval(path);
  if (&path != &used() || !path.works) return next;
  // An answer is overdue: challenge again before the path times out.
  const Time soon = std::max(path.asked + keep_alive_ / 4, alive_at(path) + keep_alive_ + rtt);
  return std::min(next, soon);
}

Time Paths::dead_at(const Path& path, Duration rtt) const {
  if (!path.works) return kNever;
  if (&path == &used())
    return alive_at(path) + 2 * keep_alive_ + std::min(2 * rtt, keep_alive_ / 2);
  return path.answered + 7 * interval(path) / 2;
}

// --- time

Time Paths::next_timeout(Duration rtt) const {
  if (!several()) return kNever;
  Time next = kNever;
  for (const Path& path : paths_) {
    next = std::min({next, next_question(path, rtt), dead_at(path, rtt)});
  }
  return next;
}

bool Paths::on_timeout(Time now, Duration rtt) {
  if (!several()) return false;
  for (Path& path : paths_) {
    if (now >= dead_at(path, rtt)) fail(now, path);
  }
  return choose(now);
}

// --- counters

void Paths::count_in(PathKind kind, std::size_t bytes) {
  Path* path = mine(kind);
  if (path == nullptr) return;
  ++path->counters.datagrams_in;
  path->counters.bytes_in += bytes;
}

void Paths::count_out(PathKind kind, std::size_t bytes) {
  Path* path = mine(kind);
  if (path == nullptr) return;
  ++path->counters.datagrams_out;
  path->counters.bytes_out += bytes;
}

}  // namespace tims::link

#include "tools/configuration/host_change.h"

#include <algorithm>
#include <array>

namespace timsctl::configuration {
namespace {

constexpr std::array<std::string_view, 4> kOutcomes{"pending", "confirmed", "went_back", "found"};
constexpr std::array<std::string_view, 4> kStandings{"unknown", "under_way", "confirmed",
                                                     "went_back"};
constexpr std::array<std::string_view, 6> kStates{"idle",    "locked",   "applying",
                                                  "waiting", "settling", "going_back"};

template <typename Enum, std::size_t N>
std::optional<Enum> value_of(const std::array<std::string_view, N>& names, std::string_view name) {
  const auto* const found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Enum>(found - names.begin());
}

std::string seconds_text(tims::Duration time) {
  return std::to_string(std::chrono::duration_cast<std::chrono::seconds>(time).count()) + " s";
}

}  // namespace

std::string_view name_of(Outcome outcome) {
  return kOutcomes.at(static_cast<std::size_t>(outcome));
}
std::optional<Outcome> outcome_of(std::string_view name) {
  return value_of<Outcome>(kOutcomes, name);
}
std::string_view name_of(State state) { return kStates.at(static_cast<std::size_t>(state)); }
std::string_view name_of(Standing standing) {
  return kStandings.at(static_cast<std::size_t>(standing));
}
std::optional<Standing> standing_of(std::string_view name) {
  return value_of<Standing>(kStandings, name);
}

const Item* Record::find(Generation generation) const {
  const auto found = std::ranges::find(items, generation, &Item::generation);
  return found == items.end() ? nullptr : &*found;
}

const Item* Record::find_change(std::string_view change) const {
  const auto found = std::ranges::find(items, change, &Item::change);
  return found == items.end() || change.empty() ? nullptr : &*found;
}

HostChange::HostChange(tims::Time now, Record record) : record_(std::move(record)) {
  if (!record_.untold.empty()) ask_at_ = now;
  if (!record_.pending) return;
  switch (record_.pending->state) {
    case State::kSettling:
      // Confirmed: the others may be, too. There is new time to ask them.
      deadline_ = now + kSettleTime;
      ask_at_ = now;
      break;
    case State::kGoingBack:
      go_back(record_.pending->reason);
      break;
    default:
      go_back("the agent was restarted before the change was confirmed");
  }
}

State HostChange::state(tims::Time now) const {
  if (record_.pending) return record_.pending->state;
  return lock_.empty() || now >= lock_end_ ? State::kIdle : State::kLocked;
}

const Item* HostChange::pending() const {
  return record_.pending ? record_.find(record_.pending->generation) : nullptr;
}

std::string HostChange::lock_holder(tims::Time now) const {
  return state(now) == State::kLocked ? lock_holder_ : std::string();
}

tims::Duration HostChange::left(tims::Time now) const {
  const tims::Time end = state(now) == State::kLocked ? lock_end_ : deadline_;
  return end == tims::kNever ? tims::Duration{} : std::max(end - now, tims::Duration{});
}

Item& HostChange::item(Generation generation) {
  return *std::ranges::find(record_.items, generation, &Item::generation);
}

Generation HostChange::found(const std::string& time, const std::string& who) {
  const Generation generation = next();
  record_.items.push_back({.generation = generation,
                           .from = record_.current,
                           .who = who,
                           .time = time,
                           .outcome = Outcome::kFound});
  record_.last = record_.current = generation;
  forget_old();
  save();
  return generation;
}

// The oldest, but neither the current one nor that of before a change which is under way.
void HostChange::forget_old() {
  const auto is_needed = [&](const Item& each) {
    const Item* now = pending();
    return each.generation == record_.current || (now != nullptr && each.change == now->change) ||
           (now != nullptr && each.generation == now->from);
  };
  for (auto each = record_.items.begin();
       record_.items.size() > kGenerationsKept && each != record_.items.end();)
    each = is_needed(*each) ? std::next(each) : record_.items.erase(each);
}

// --- what people ask

Refused HostChange::lock(tims::Time now, const std::string& change, const std::string& who,
                         tims::Duration time) {
  if (auto refused = may_begin(now, change)) return refused;
  lock_ = change;
  lock_holder_ = who;
  lock_end_ = now + std::clamp(time, tims::Duration(std::chrono::seconds(1)), kLockMax);
  return {};
}

Refused HostChange::unlock(tims::Time now, const std::string& change) {
  if (state(now) == State::kLocked && lock_ != change)
    return Refusal{"locked", "locked by " + lock_holder_};
  lock_.clear();
  return {};
}

Refused HostChange::may_begin(tims::Time now, const std::string& change) const {
  if (const Item* other = pending())
    return Refusal{"busy", "a change of " + other->who + " is under way (" +
                               std::string(name_of(record_.pending->state)) + ", " +
                               seconds_text(left(now)) + " left)"};
  if (state(now) == State::kLocked && lock_ != change)
    return Refusal{"locked", "locked by " + lock_holder_ + " for " + seconds_text(left(now))};
  if (record_.find_change(change) != nullptr)
    return Refusal{"bad_argument", "this change was already made: choose another id"};
  return {};
}

Refused HostChange::begin(tims::Time now, Item item, tims::Duration window) {
  if (auto refused = may_begin(now, item.change)) return refused;
  item.generation = next();
  item.from = record_.current;
  item.outcome = Outcome::kPending;
  window_ = std::clamp(window, kWindowMin, kWindowMax);
  deadline_ = tims::kNever;
  lock_.clear();
  peers_.clear();
  record_.last = item.generation;
  record_.pending = Record::Pending{.generation = item.generation};
  save();
  steps_.push_back({.kind = Step::Kind::kWrite, .generation = item.generation});
  steps_.push_back({.kind = Step::Kind::kApply, .from = item.from, .generation = item.generation});
  record_.items.push_back(std::move(item));
  forget_old();
  return {};
}

Refused HostChange::need(const std::string& change) const {
  const Item* now = pending();
  if (now != nullptr && now->change == change) return {};
  const Item* known = record_.find_change(change);
  if (known == nullptr) return Refusal{"no_such_change", "no change " + change + " was made here"};
  return Refusal{"no_such_change", "this change is over: " + std::string(name_of(known->outcome)) +
                                       (known->reason.empty() ? "" : ", " + known->reason)};
}

Refused HostChange::confirm(tims::Time now, const std::string& change) {
  const Item* known = record_.find_change(change);
  if (known != nullptr && known->outcome == Outcome::kConfirmed) return {};  // again
  if (auto refused = need(change)) return refused;
  switch (record_.pending->state) {
    case State::kSettling:
      return {};
    case State::kWaiting:
      break;
    default:
      return Refusal{"busy",
                     "not yet to be confirmed: " + std::string(name_of(record_.pending->state))};
  }
  record_.pending->state = State::kSettling;
  if (pending()->others.empty()) {
    finish(Outcome::kConfirmed);
    return {};
  }
  deadline_ = now + kSettleTime;
  ask_at_ = now;
  save();
  settle_if_all_are(now);
  return {};
}

Refused HostChange::undo(tims::Time, const std::string& change, const std::string& reason) {
  if (auto refused = need(change)) return refused;
  if (record_.pending->state != State::kGoingBack) go_back(reason);
  return {};
}

// --- going on

void HostChange::go_back(const std::string& reason) {
  go_back_to(record_.pending->generation, reason);
}

// From this generation to the one before.
void HostChange::go_back_to(Generation generation, const std::string& reason) {
  record_.pending =
      Record::Pending{.generation = generation, .state = State::kGoingBack, .reason = reason};
  deadline_ = tims::kNever;
  ask_at_ = untold_at();
  const Generation before = item(generation).from;
  steps_.clear();
  save();
  steps_.push_back({.kind = Step::Kind::kWrite, .generation = before});
  steps_.push_back({.kind = Step::Kind::kApply, .from = generation, .generation = before});
}

// The others that have not heard of going back are told at once.
tims::Time HostChange::untold_at() const {
  return record_.untold.empty() ? tims::kNever : tims::Time{};
}

void HostChange::finish(Outcome outcome) {
  Item& made = item(record_.pending->generation);
  made.outcome = outcome;
  made.reason = record_.pending->reason;
  record_.current = outcome == Outcome::kConfirmed ? made.generation : made.from;
  if (outcome == Outcome::kWentBack && !made.others.empty())
    record_.untold[made.change] = made.others;
  record_.pending.reset();
  deadline_ = tims::kNever;
  tell_pause_ = kAskPeers;
  ask_at_ = untold_at();
  save();
}

void HostChange::done(tims::Time now) {
  const Step step = steps_.front();
  steps_.pop_front();
  if (step.kind != Step::Kind::kApply || !record_.pending) return;
  if (record_.pending->state == State::kApplying) {
    record_.pending->state = State::kWaiting;  // for a restart it is the same as applying
    deadline_ = now + window_;
  } else if (record_.pending->state == State::kGoingBack) {
    finish(Outcome::kWentBack);
  }
}

void HostChange::failed(tims::Time now, const std::string& reason) {
  steps_.clear();
  if (!record_.pending) {
    save();
  } else if (record_.pending->state == State::kGoingBack) {
    deadline_ = now + kAskPeers;  // the disk may be full: try again
  } else {
    go_back(reason);
  }
}

tims::Time HostChange::next_timeout() const { return std::min(deadline_, ask_at_); }

void HostChange::on_timeout(tims::Time now) {
  if (now < deadline_ || !record_.pending) return;
  switch (record_.pending->state) {
    case State::kWaiting:
      go_back("not confirmed in " + seconds_text(window_));
      break;
    case State::kSettling:
      go_back("not all other hosts of the change could be asked");
      break;
    case State::kGoingBack:
      go_back(record_.pending->reason);
      break;
    default:
      break;
  }
}

// --- other hosts

Standing HostChange::standing(std::string_view change) const {
  const Item* known = record_.find_change(change);
  if (known == nullptr) return Standing::kUnknown;
  if (record_.pending && record_.pending->generation == known->generation) {
    if (record_.pending->state == State::kSettling) return Standing::kConfirmed;
    return record_.pending->state == State::kGoingBack ? Standing::kWentBack : Standing::kUnderWay;
  }
  return known->outcome == Outcome::kConfirmed ? Standing::kConfirmed : Standing::kWentBack;
}

std::vector<HostChange::Peer> HostChange::peers_to_ask(tims::Time now) {
  std::vector<Peer> all;
  if (now < ask_at_) return all;
  const bool settles = record_.pending && record_.pending->state == State::kSettling;
  if (settles)
    for (const std::string& agent : pending()->others)
      if (peers_[agent] != Standing::kConfirmed)
        all.push_back({agent, pending()->change, Standing::kConfirmed});
  for (const auto& [change, agents] : record_.untold)
    for (const std::string& agent : agents) all.push_back({agent, change, Standing::kWentBack});
  ask_at_ = all.empty() ? tims::kNever : now + (settles ? kAskPeers : tell_pause_);
  if (!settles) tell_pause_ = std::min(2 * tell_pause_, kTellPeersMost);
  return all;
}

void HostChange::settle_if_all_are(tims::Time) {
  if (!record_.pending || record_.pending->state != State::kSettling) return;
  const bool all = std::ranges::all_of(pending()->others, [&](const std::string& agent) {
    return peers_[agent] == Standing::kConfirmed;
  });
  if (!all) return;
  finish(Outcome::kConfirmed);
}

void HostChange::heard(tims::Time now, const std::string& agent, const std::string& change,
                       Standing standing) {
  const Item* known = record_.find_change(change);
  if (known == nullptr) return;
  if (std::ranges::find(known->others, agent) == known->others.end()) return;
  const bool is_pending = pending() == known;
  if (is_pending) peers_[agent] = standing;
  if (standing == Standing::kWentBack || (standing == Standing::kUnknown && is_pending)) {
    const std::string reason = "another host of the change went back";
    if (is_pending && record_.pending->state != State::kGoingBack) return go_back(reason);
    if (!record_.pending && known->outcome == Outcome::kConfirmed &&
        record_.current == known->generation)
      go_back_to(known->generation, reason);
    return;
  }
  settle_if_all_are(now);
}

void HostChange::answered(tims::Time now, const std::string& agent, const std::string& change,
                          Standing standing) {
  const auto untold = record_.untold.find(change);
  if (untold != record_.untold.end()) {
    std::erase(untold->second, agent);
    if (untold->second.empty()) record_.untold.erase(untold);
    save();
    return;
  }
  heard(now, agent, change, standing);
}

}  // namespace timsctl::configuration

#include "tests/sched/all_traces.h"

#include <algorithm>
#include <bit>
#include <cstdlib>

namespace tims::sched {
namespace {

std::size_t at(int thread) { return static_cast<std::size_t>(thread); }

template <typename Clock>
void merge(Clock& into, const Clock& other) {
  for (std::size_t i = 0; i < into.size(); ++i) into[i] = std::max(into[i], other[i]);
}

}  // namespace

int AllTraces::choose(const Moment& moment) {
  if (redundant_) return first_of(moment.runnable);
  const std::size_t depth = depth_;
  if (depth == nodes_.size() && !extend(moment)) {
    redundant_ = true;
    return first_of(moment.runnable);
  }
  Node& node = nodes_[depth];
  if (!contains(moment.runnable, node.chosen)) std::abort();  // runs that cannot be repeated
  // The records of the steps before the last choice remain valid.
  if (depth + 1 == nodes_.size()) record(node, moment.next[at(node.chosen)], depth);
  clocks_[at(node.chosen)] = node.clock;
  ++depth_;
  return node.chosen;
}

// A thread may wait for ever because of the order of other threads' steps.
void AllTraces::at_end(const Moment& moment) {
  if (redundant_) return;
  for (int i = 0; i < static_cast<int>(moment.next.size()); ++i)
    if (contains(moment.alive, i)) find_races(i, moment.next[at(i)], depth_);
}

// Appends a step. False: every thread that could run here was tried before.
bool AllTraces::extend(const Moment& moment) {
  Node node;
  node.runnable = moment.runnable;
  if (!nodes_.empty()) {
    const Node& before = nodes_.back();
    for (int i = 0; i < static_cast<int>(moment.next.size()); ++i)
      if (contains(before.asleep, i) && !dependent(moment.next[at(i)], before.operation))
        node.asleep |= only(i);
  }
  const Threads awake = node.runnable & ~node.asleep;
  if (awake == 0) return false;
  const bool goes_on = moment.last >= 0 && contains(awake, moment.last);
  node.chosen = goes_on ? moment.last : first_of(awake);
  node.to_try = only(node.chosen);
  nodes_.push_back(node);
  return true;
}

void AllTraces::record(Node& node, Operation operation, std::size_t depth) {
  node.operation = operation;
  find_races(node.chosen, operation, depth);
  node.clock = happened_before(node.chosen, operation, depth);
  node.clock[at(node.chosen)] = depth + 1;
}

AllTraces::Clock AllTraces::happened_before(int thread, Operation next, std::size_t depth) const {
  Clock clock = clocks_[at(thread)];
  for (std::size_t i = 0; i < depth; ++i)
    if (dependent(nodes_[i].operation, next)) merge(clock, nodes_[i].clock);
  return clock;
}

// A step races with `next` when the two depend on each other and nothing else orders them. Any of
// the steps before may have released a thread that waited, so such a thread races with all of them.
void AllTraces::find_races(int thread, Operation next, std::size_t depth) {
  const Clock clock = happened_before(thread, next, depth);
  Clock ordered = clocks_[at(thread)];
  for (std::size_t i = depth; i-- > 0;) {
    const Node& earlier = nodes_[i];
    if (!dependent(earlier.operation, next) || ordered[at(earlier.chosen)] > i) continue;
    if (next.waits)
      nodes_[i].to_try |= earlier.runnable;
    else
      reverse(i, thread, clock, depth);
    if (!next.waits) merge(ordered, earlier.clock);
  }
}

// Schedules a thread at step `earlier` that can begin a run in which `thread` precedes that step.
void AllTraces::reverse(std::size_t earlier, int thread, const Clock& clock, std::size_t depth) {
  Node& node = nodes_[earlier];
  const Threads beginners = could_begin(earlier, thread, clock, depth);
  if ((beginners & node.to_try) != 0) return;
  node.to_try |= contains(beginners, thread) ? only(thread) : only(first_of(beginners));
}

// The threads whose step can be first among the steps after `earlier` that do not depend on it,
// followed by the step of `thread` (initials of the sequence, Abdulla et al.).
Threads AllTraces::could_begin(std::size_t earlier, int thread, const Clock& clock,
                               std::size_t depth) const {
  const int overtaken = nodes_[earlier].chosen;
  Threads beginners = 0;
  std::vector<std::size_t> steps;
  const auto consider = [&](int candidate, const Clock& before) {
    for (const std::size_t i : steps)
      if (before[at(nodes_[i].chosen)] > i) return;
    beginners |= only(candidate);
  };
  for (std::size_t i = earlier + 1; i < depth; ++i) {
    const Node& node = nodes_[i];
    if (node.clock[at(overtaken)] > earlier) continue;
    consider(node.chosen, node.clock);
    steps.push_back(i);
  }
  consider(thread, clock);
  return beginners;
}

bool AllTraces::next_run() {
  depth_ = 0;
  clocks_ = {};
  redundant_ = false;
  while (!nodes_.empty()) {
    Node& node = nodes_.back();
    node.asleep |= only(node.chosen);
    const Threads left = node.to_try & ~node.asleep;
    if (left != 0) {
      node.chosen = first_of(left);
      return true;
    }
    nodes_.pop_back();
  }
  return false;
}

}  // namespace tims::sched

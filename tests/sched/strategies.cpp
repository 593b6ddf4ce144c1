#include "tests/sched/strategies.h"

#include <bit>
#include <cstdlib>
#include <sstream>

namespace tims::sched {
namespace {

// A scenario whose runs depend on anything but the choices cannot be searched.
int certainly(int chosen, const Moment& moment) {
  if (!contains(moment.runnable, chosen)) std::abort();
  return chosen;
}

}  // namespace

int FewPreemptions::choose(const Moment& moment) {
  if (depth_ == choices_.size()) {
    Choice choice;
    choice.interrupts = moment.last >= 0 && contains(moment.runnable, moment.last);
    choice.chosen = choice.interrupts ? moment.last : first_of(moment.runnable);
    if (!choice.interrupts || preemptions_ < preemptions_max_)
      choice.untried = moment.runnable & ~only(choice.chosen);
    choices_.push_back(choice);
  }
  const Choice& choice = choices_[depth_++];
  if (choice.interrupts && choice.chosen != moment.last) ++preemptions_;
  return certainly(choice.chosen, moment);
}

bool FewPreemptions::next_run() {
  depth_ = 0;
  preemptions_ = 0;
  while (!choices_.empty() && choices_.back().untried == 0) choices_.pop_back();
  if (choices_.empty()) return false;
  Choice& choice = choices_.back();
  choice.chosen = first_of(choice.untried);
  choice.untried &= ~only(choice.chosen);
  return true;
}

int Random::choose(const Moment& moment) {
  const bool can_go_on = moment.last >= 0 && contains(moment.runnable, moment.last);
  if (can_go_on && random_() % stretch_ != 0) return moment.last;
  Threads left = moment.runnable;
  for (auto skip = random_() % static_cast<unsigned>(std::popcount(left)); skip > 0; --skip)
    left &= left - 1;
  return first_of(left);
}

bool Random::next_run() {
  stretch_ = 1U << random_() % 5;
  return --runs_ > 0;
}

// After its end, or if the code has changed since: the first runnable thread.
int Replay::choose(const Moment& moment) {
  const int written = depth_ < schedule_.size() ? schedule_[depth_++] : -1;
  return written >= 0 && contains(moment.runnable, written) ? written : first_of(moment.runnable);
}

std::string to_text(const std::vector<int>& schedule) {
  std::ostringstream text;
  for (std::size_t i = 0; i < schedule.size();) {
    std::size_t end = i;
    while (end < schedule.size() && schedule[end] == schedule[i]) ++end;
    text << (i == 0 ? "" : " ") << schedule[i] << '*' << end - i;
    i = end;
  }
  return text.str();
}

std::vector<int> from_text(const std::string& text) {
  std::istringstream fields(text);
  std::vector<int> schedule;
  int thread = 0;
  char star = 0;
  std::size_t count = 0;
  while (fields >> thread >> star >> count) schedule.insert(schedule.end(), count, thread);
  return schedule;
}

}  // namespace tims::sched

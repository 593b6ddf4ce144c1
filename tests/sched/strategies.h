// Schedules by depth-first search with few preemptions, random ones, and a recorded one.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "tests/sched/strategy.h"

namespace tims::sched {

// Every schedule with at most `preemptions_max` interruptions of a thread that could continue.
// Most errors of lock-free algorithms need one or two.
class FewPreemptions : public Strategy {
 public:
  static constexpr int kUnlimited = 1 << 20;
  explicit FewPreemptions(int preemptions_max) : preemptions_max_(preemptions_max) {}

  int choose(const Moment& moment) override;
  bool next_run() override;

 private:
  struct Choice {
    int chosen = 0;
    Threads untried = 0;
    bool interrupts = false;  // another choice than the first is a preemption
  };
  int preemptions_max_;
  std::vector<Choice> choices_;
  std::size_t depth_ = 0;
  int preemptions_ = 0;
};

// `runs` schedules from a seed: some with long stretches of one thread, some with short ones.
class Random : public Strategy {
 public:
  Random(std::uint32_t seed, std::uint64_t runs) : random_(seed), runs_(runs) {}

  int choose(const Moment& moment) override;
  bool next_run() override;

 private:
  std::mt19937 random_;
  std::uint64_t runs_;
  unsigned stretch_ = 2;  // mean number of steps between interruptions
};

// The schedule of an earlier run: the thread of each step.
class Replay : public Strategy {
 public:
  explicit Replay(std::vector<int> schedule) : schedule_(std::move(schedule)) {}

  int choose(const Moment& moment) override;
  bool next_run() override { return false; }

 private:
  std::vector<int> schedule_;
  std::size_t depth_ = 0;
};

// "0*12 1*3": twelve steps of thread 0, then three of thread 1.
std::string to_text(const std::vector<int>& schedule);
std::vector<int> from_text(const std::string& text);

}  // namespace tims::sched

// A chaos run: rounds of faults, each followed by a time without faults and by checks.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/chaos/board.h"
#include "tests/chaos/judge.h"

namespace tims::chaos {

struct Settings {
  std::uint64_t seed = 1;
  Duration length{};
  std::size_t robots = 3;
};

class Run {
 public:
  Run(const Settings& settings, const timsctl::Signals& signals);

  // Runs all rounds. True: no violation. Throws timsctl::Failure if a fleet cannot be created here.
  bool go();

 private:
  void round(std::size_t number);
  void trouble(const Round& round);
  void heal();
  void settle();
  void tour();
  void calm();
  bool is_calm();
  void judge_losses(const Losses& missing_before, const Losses& counted_before);
  void finish_round();

  [[nodiscard]] std::uint64_t received() const;
  // Missing messages of all flows except samples, which may be lost.
  [[nodiscard]] std::vector<std::uint32_t> missing() const;
  [[nodiscard]] Losses missing_by_class() const;
  void await_quiet();

  // Waits until `missing` returns an empty text; a timeout is a violation. Returns the duration.
  template <typename Missing>
  Duration await(const char* what, Missing missing);
  void pause_until(Time deadline) const { (void)signals_.wait(-1, deadline); }
  void act(const Step& step);
  void report(const std::string& text) const;
  void wrong(const std::string& text);
  void keep();

  const Settings settings_;
  const timsctl::Signals& signals_;
  const Time began_;
  const Shape shape_;
  const std::string folder_;
  const SharedBoard board_;
  std::optional<timsctl::sim::RunningFleet> fleet_;
  std::optional<Judge> judge_;
  std::size_t wrongs_ = 0;
  std::size_t steps_ = 0;
  Duration slowest_{};  // longest time until the routers had settled
};

}  // namespace tims::chaos

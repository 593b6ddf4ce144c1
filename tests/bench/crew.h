// The processes of one measurement. They end with it, however it ends.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/bench/experiment.h"
#include "tests/bench/plan.h"
#include "tests/bench/usage.h"
#include "tests/support/child_process.h"

namespace tims::bench {

class Crew {
 public:
  Crew(const Setting& setting, const Experiment& experiment);
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  // The router or the relay; returns when it listens.
  Result<void> start_between();
  // Returns when the process is ready to receive.
  Result<void> start(Plan plan);
  // Until all roles have ended; what each has measured, and what the one between them cost.
  Result<std::vector<Metrics>> wait(Duration limit);

  [[nodiscard]] pid_t between() const { return between_.front().pid(); }

 private:
  struct Member {
    std::string role;
    test::ChildProcess process;
    std::string trace;  // strace's summary
  };

  Result<test::ChildProcess> launch(std::vector<std::string> command) const;
  Result<Metrics> result_of(Member& member, Duration limit) const;

  const Setting& setting_;
  const Experiment& experiment_;
  std::string folder_;
  std::string socket_;
  std::string endpoint_;
  std::vector<test::ChildProcess> between_;  // at most one
  Usage between_before_;
  std::vector<Member> members_;
};

}  // namespace tims::bench

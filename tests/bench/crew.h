// The processes of one measurement. They are killed when it ends.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/bench/experiment.h"
#include "tests/bench/middle.h"
#include "tests/bench/plan.h"
#include "tests/support/child_process.h"

namespace tims::bench {

class Crew {
 public:
  Crew(const Setting& setting, const Experiment& experiment);
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  // Starts the routers or relays between the roles; returns when they are ready.
  Result<void> start_middle();
  // Returns when the process is ready to receive.
  Result<void> start(Plan plan);
  // Waits until all roles have exited; returns their metrics, and the cost of the processes
  // between.
  Result<std::vector<Metrics>> wait(Duration limit);

  [[nodiscard]] const Middle& middle() const { return middle_; }

 private:
  struct Member {
    std::string role;
    test::ChildProcess process;
    std::string trace;  // strace's summary
  };

  Result<Metrics> result_of(Member& member, Duration limit) const;

  const Setting& setting_;
  const Experiment& experiment_;
  std::string folder_;
  Middle middle_;
  Usage before_;  // of the processes between
  std::vector<Member> members_;
};

}  // namespace tims::bench

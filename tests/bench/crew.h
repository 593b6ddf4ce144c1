// The processes of one measurement. They end with it, however it ends.
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

  // What stands between; returns when it is ready.
  Result<void> start_middle();
  // Returns when the process is ready to receive.
  Result<void> start(Plan plan);
  // Until all roles have ended; what each has measured, and what cost those between them.
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
  Usage before_;  // of those between
  std::vector<Member> members_;
};

}  // namespace tims::bench

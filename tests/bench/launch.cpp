#include "tests/bench/launch.h"

#include <cstdio>

#include <sched.h>

namespace tims::bench {
namespace {

// Children inherit the CPUs of the thread that starts them.
class OnLastCpu {
 public:
  OnLastCpu() {
    ::sched_getaffinity(0, sizeof all_, &all_);
    cpu_set_t last;
    CPU_ZERO(&last);
    for (std::size_t cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
      if (!CPU_ISSET(cpu, &all_)) continue;
      CPU_ZERO(&last);
      CPU_SET(cpu, &last);
    }
    ::sched_setaffinity(0, sizeof last, &last);
  }
  ~OnLastCpu() { ::sched_setaffinity(0, sizeof all_, &all_); }
  OnLastCpu(const OnLastCpu&) = delete;
  OnLastCpu& operator=(const OnLastCpu&) = delete;

 private:
  cpu_set_t all_{};
};

}  // namespace

Result<test::ChildProcess> launch(std::vector<std::string> command, bool one_cpu) {
  if (!one_cpu) return test::ChildProcess::start(std::move(command));
  const OnLastCpu pinned;
  return test::ChildProcess::start(std::move(command));
}

bool complain(const Error& error) {
  std::fprintf(stderr, "%s\n", error.message().c_str());
  return false;
}

}  // namespace tims::bench

// What the demo components share: their signal handling and their arguments.
#pragma once

#include <csignal>
#include <cstdint>
#include <cstdio>
#include <ctime>

#include "components/demo/arguments.h"
#include "tims/session.h"

namespace tims::demo {

// SIGINT and SIGTERM, blocked and asked for, instead of a handler.
class StopSignals {
 public:
  StopSignals() {
    sigemptyset(&set_);
    sigaddset(&set_, SIGINT);
    sigaddset(&set_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
  }
  // Waits until `deadline` at most; true when it is time to stop.
  [[nodiscard]] bool stop_within(Duration wait) const {
    const timespec t{static_cast<time_t>(wait.count() / 1'000'000'000),
                     static_cast<long>(wait.count() % 1'000'000'000)};
    return sigtimedwait(&set_, nullptr, &t) > 0;
  }

 private:
  sigset_t set_;
};

inline Time now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return Time(std::chrono::seconds(t.tv_sec) + Duration(t.tv_nsec));
}

inline int failed(const char* what, const Error& error) {
  std::fprintf(stderr, "%s: %s\n", what, error.message().c_str());
  return 1;
}

int run_ladar(Session& session, const StopSignals& signals, const Arguments& arguments);
int run_viewer(Session& session, const StopSignals& signals, const Arguments& arguments);
int run_server(Session& session, const StopSignals& signals, const Arguments& arguments);
int run_client(Session& session, const StopSignals& signals, const Arguments& arguments);

inline constexpr std::int8_t kReverse = 21;  // the server's one command

}  // namespace tims::demo

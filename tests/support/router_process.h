// A real tims-router with its own folder, for one test.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/child_process.h"
#include "tests/support/patience.h"
#include "tests/support/temporary_folder.h"

namespace tims::test {

// A setting; clients that do not answer within this time are closed.
inline std::string lifesign_interval(std::chrono::milliseconds interval) {
  return "lifesign.interval=" + std::to_string(kSlowdown * interval.count()) + "ms";
}

class RouterProcess {
 public:
  // `settings`: "key=value", in addition to the test's defaults; a later one takes precedence.
  explicit RouterProcess(std::vector<std::string> settings = {});
  RouterProcess(const RouterProcess&) = delete;
  RouterProcess& operator=(const RouterProcess&) = delete;

  // Returns when the router listens on all ports; an error contains the router's output.
  Result<void> start();
  void kill();                // SIGKILL, and waits for the exit
  Result<ExitStatus> stop();  // SIGTERM

  [[nodiscard]] std::string folder() const { return folder_.path(); }
  [[nodiscard]] std::string socket_path() const { return folder_.path() / "router.sock"; }
  [[nodiscard]] const std::string& tcp() const { return tcp_; }    // "127.0.0.1:40312"
  [[nodiscard]] const std::string& http() const { return http_; }  // empty when it is off
  [[nodiscard]] ChildProcess& process() { return *process_; }

 private:
  TemporaryFolder folder_;  // outlives the process
  std::vector<std::string> settings_;
  std::string tcp_;
  std::string http_;
  std::optional<ChildProcess> process_;
};

}  // namespace tims::test

// The hosts of a deployment together: none is changed before all are prepared, so that whatever can
// fail without a change fails before the first. From then on each host is on its own: it comes up
// or goes back. Pure.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/deploy/host_run.h"

namespace timsctl::deploy {

class Rollout {
 public:
  Rollout(std::vector<std::string> names, bool undo);

  [[nodiscard]] std::size_t size() const { return hosts_.size(); }
  HostRun& host(std::size_t number) { return hosts_[number]; }
  [[nodiscard]] const HostRun& host(std::size_t number) const { return hosts_[number]; }
  [[nodiscard]] const std::string& name(std::size_t number) const { return names_[number]; }

  // After each outcome: a host that cannot be prepared ends the deployment of the others. Returns
  // the hosts whose commands are to be ended.
  std::vector<std::size_t> settle();
  // Whether all hosts are ready and wait for go() or cancel().
  [[nodiscard]] bool is_ready() const;
  void go();
  void cancel(const std::string& reason);
  // Ctrl-C.
  void stop();

  [[nodiscard]] bool is_over() const;
  [[nodiscard]] tims::Time next_begin() const;
  // Whether all hosts are as it was wanted.
  [[nodiscard]] bool succeeded() const;

 private:
  std::vector<std::string> names_;
  std::vector<HostRun> hosts_;
  bool gone_ = false;
};

}  // namespace timsctl::deploy

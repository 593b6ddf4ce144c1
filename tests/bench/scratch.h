// A folder in memory for one run. It is removed when the run ends, also by Ctrl-C, together with
// the hosts.
#pragma once

#include <string>
#include <thread>

namespace tims::bench {

class Scratch {
 public:
  Scratch();
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  void wait_for_signal() const;

  std::string path_;
  std::thread watcher_;
};

}  // namespace tims::bench

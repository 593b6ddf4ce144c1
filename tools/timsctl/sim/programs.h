// The routers and components of a fleet, as processes.
#pragma once

#include <functional>
#include <list>
#include <string>
#include <vector>

#include "tools/timsctl/json.h"
#include "tools/timsctl/signals.h"
#include "tools/timsctl/sim/plan.h"
#include "tools/timsctl/sim/process.h"

namespace timsctl::sim {

class Programs {
 public:
  explicit Programs(const Plan& plan);

  // Starts what does not run of the host: its router first, then its components.
  void start(const PlannedHost& host, const Signals& signals);
  // All routers side by side, then all components.
  void start_all(const Signals& signals);

  enum class Part : std::uint8_t { kAll, kRouter };
  // As if it lost its power. The number of programs that were ended.
  std::size_t kill(const PlannedHost& host, Part part);
  // Asks everybody to end, components first, and does not wait for ever.
  void end_all();

  // Everything of which to wait for an end.
  [[nodiscard]] std::vector<int> descriptors() const;
  struct End {
    std::string host;
    std::string label;
    int status = 0;
    std::string last_words;  // the end of its log
  };
  // Those that have ended since, by themselves.
  std::vector<End> ended();

  [[nodiscard]] json::array report(const PlannedHost& host) const;

 private:
  struct Program {
    const PlannedHost* host;
    bool router;
    std::string label;
    Launch launch;
    std::optional<Child> child;
    int status = 0;  // of its last end
  };

  void start(Program& program);
  void await_router(Program& program, const Signals& signals);
  template <typename Condition>
  void end(Condition concerned, int signal);

  std::list<Program> programs_;
};

std::string end_text(int status);  // "exit status 1", "killed by signal 9"

}  // namespace timsctl::sim

// The routers and components of a fleet, as processes.
#pragma once

#include <functional>
#include <list>
#include <string>
#include <vector>

#include "tools/timsctl/json.h"
#include "tools/timsctl/process.h"
#include "tools/timsctl/signals.h"
#include "tools/timsctl/sim/plan.h"

namespace timsctl::sim {

class Programs {
 public:
  explicit Programs(const Plan& plan);

  // Starts what does not run of the host: its router first, then its components.
  void start(const PlannedHost& host, const Signals& signals);
  // All routers side by side, then all components.
  void start_all(const Signals& signals);

  // As if it lost its power; or only the `router`, or what has `part` in its command. The number of
  // programs that were ended. Throws Failure when the host has no such program.
  std::size_t kill(const PlannedHost& host, std::string_view part);
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

}  // namespace timsctl::sim

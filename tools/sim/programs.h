// The routers and components of a fleet, as processes.
#pragma once

#include <list>
#include <optional>
#include <string>
#include <vector>

#include "tools/cli/connection.h"
#include "tools/cli/context.h"
#include "tools/cli/output.h"
#include "tools/cli/service.h"
#include "tools/sim/plan.h"

namespace timsctl::sim {

class Programs {
 public:
  explicit Programs(const Plan& plan);

  // Starts the programs of the host that do not run: the router first, then the components.
  void start(const PlannedHost& host, const Signals& signals);
  // Starts all routers in parallel, then all components.
  void start_all(const Signals& signals);

  // Kills all programs of the host, only its `router`, or those with `part` in their command.
  // Returns the number of killed programs. Throws Failure if the host has no such program.
  std::size_t kill(const PlannedHost& host, std::string_view part);
  // Terminates all programs, components first, with a time limit.
  void end_all();

  // File descriptors that become readable when a program ends.
  [[nodiscard]] std::vector<int> descriptors() const;
  struct End {
    std::string host;
    std::string label;
    tims::os::ExitStatus status;
    std::string stop_commands;  // last lines of its log
  };
  // Programs that have ended unexpectedly since the last call.
  std::vector<End> ended();
  // A router that ended without `sim kill` is started again after a moment, as by its service:
  // agents restart it so. When the next one is due, and starting those that are: their hosts.
  [[nodiscard]] tims::Time next_restart() const;
  std::vector<const PlannedHost*> restart_routers(tims::Time now);

  [[nodiscard]] json::array report(const PlannedHost& host) const;

 private:
  struct Program {
    const PlannedHost* host;
    bool router;
    std::string label;
    Launch launch;
    Child child;
    tims::os::ExitStatus status;  // of its last run
    tims::Time restart_at = tims::kNever;
  };

  void start(Program& program);
  void await_router(Program& program, const Signals& signals);
  template <typename Condition>
  void end(Condition concerned, int signal);

  std::list<Program> programs_;
};

// Requests to the routers of a fleet over their sockets.

class Routers {
 public:
  Routers(const Context& context, const Plan& plan) : context_(context), plan_(plan) {}

  // Lets a router apply faults to the datagrams that it sends over a link. False: the link does not
  // exist yet.
  [[nodiscard]] bool inject_faults(const std::string& host, const std::string& peer,
                                   const Quality& quality) const;
  // Whether the link of the host to that peer is up.
  [[nodiscard]] bool is_linked(const std::string& host, const std::string& peer) const;

 private:
  // Empty without an answer or if the router refuses.
  [[nodiscard]] std::optional<json::object> ask(const std::string& host,
                                                const json::object& question) const;

  const Context& context_;
  const Plan& plan_;
};

}  // namespace timsctl::sim

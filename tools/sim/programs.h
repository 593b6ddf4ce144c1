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
    tims::os::ExitStatus status;
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
    std::optional<Process> child;
    tims::os::ExitStatus status;  // of its last end
  };

  void start(Program& program);
  void await_router(Program& program, const Signals& signals);
  template <typename Condition>
  void end(Condition concerned, int signal);

  std::list<Program> programs_;
};

// The routers of a fleet, asked over their sockets.

class Routers {
 public:
  Routers(const Context& context, const Plan& plan) : context_(context), plan_(plan) {}

  // Asks a router to inject faults into what it sends over a link. False: not yet, there is no such
  // link.
  [[nodiscard]] bool inject_faults(const std::string& host, const std::string& peer,
                                   const Quality& quality) const;
  // Is the host's link to that peer up?
  [[nodiscard]] bool is_linked(const std::string& host, const std::string& peer) const;

 private:
  // Nothing when it does not answer, or says no.
  [[nodiscard]] std::optional<json::object> ask(const std::string& host,
                                                const json::object& question) const;

  const Context& context_;
  const Plan& plan_;
};

}  // namespace timsctl::sim

// The supervisor of a running fleet: starts it, executes its script and requests of `timsctl sim`,
// and stops it. Also the list of fleets on this host, in /run/tims-sim: a fleet is running while a
// process listens at its control socket; otherwise everything under its name is a leftover.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/context.h"
#include "tools/cli/control.h"
#include "tools/cli/failure.h"
#include "tools/cli/output.h"
#include "tools/cli/service.h"
#include "tools/sim/plan.h"
#include "tools/sim/programs.h"

namespace timsctl::sim {

// The fleets that run on this host.
const Services& running_fleets();
// All that have a folder or a namespace, running or not.
std::vector<std::string> fleets();

// The state last written by the process of the fleet; empty if there is none.
json::object read_state(std::string_view fleet);
void write_state(std::string_view fleet, const json::object& state);

// Removes everything of a fleet that does not run: processes, namespaces, files. False: there was
// nothing.
bool clean_up(std::string_view fleet);

// The name, or if it is empty the only running fleet. Throws Failure.
std::string chosen_fleet(std::string_view name);

Failure no_such(std::string_view what, std::string_view name,
                std::span<const std::string_view> known);

// Throws Failure unless this process may make namespaces.
void need_root();

class Supervisor {
 public:
  // Reserves the name on this host. Throws Failure if a fleet of that name runs.
  Supervisor(Context& context, const Plan& plan);
  // Stops and removes everything.
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  void bring_up();
  // Runs until the time or `sim down`. Throws Interrupted on Ctrl-C.
  void serve(tims::Time until);
  // The number of programs that ended unexpectedly with an error.
  [[nodiscard]] std::size_t failures() const { return failures_; }

 private:
  struct Action {
    std::string line;
    std::string host;
    tims::os::Command arguments;
    std::optional<tims::Duration> every;
  };

  void write_files() const;
  void write_state() const;
  void await_links();
  void start_clock();
  void tear_down();

  void fault(const Line& line, const tims::os::Command& arguments);
  void kill(const PlannedHost& host, std::string_view part);
  void start(const PlannedHost& host);
  void act(const Action& action);

  // The part of line faults that routers apply: repeated until they have accepted it.
  void request_faults(const Line& line, const LineState& before, const LineState& state);
  void request_all_faults(const PlannedHost& host);
  void inject_pending_faults();

  [[nodiscard]] tims::Time next_deadline(tims::Time until) const;
  void look_after_programs();
  void restart_routers();
  json::object answer(const json::object& question);
  const PlannedHost& need_host(std::string_view name) const;
  const Line& need_line(std::string_view name) const;

  Context& context_;
  EventLines events_;
  const Plan& plan_;
  Network network_;
  Programs programs_;
  Routers routers_;
  ControlServer control_;
  std::map<std::string, LineState, std::less<>> states_;
  std::multimap<tims::Time, Action> schedule_;
  // "robot1-main", "base": the router and its link, with the pending request.
  std::map<std::pair<std::string, std::string>, Quality> pending_faults_;
  tims::Time next_injection_{};
  std::string since_;
  std::size_t failures_ = 0;
};

}  // namespace timsctl::sim

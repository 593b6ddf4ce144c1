// A fleet that runs: brings it up, does what its script and `timsctl sim` say, takes it down. And
// what is there of fleets on this host, in /run/tims-sim: one runs as long as somebody listens at
// its control socket; everything else under its name is a leftover.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/connection.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/cli/output.h"
#include "tools/cli/service.h"
#include "tools/sim/plan.h"
#include "tools/sim/programs.h"

namespace timsctl::sim {

std::string folder_of(std::string_view fleet);
std::string control_socket(std::string_view fleet);

// All that have a folder or a namespace, running or not.
std::vector<std::string> fleets();
bool is_running(std::string_view fleet);

// The state as the fleet's process wrote it last; empty when it has not.
json::object read_state(std::string_view fleet);
void write_state(std::string_view fleet, const json::object& state);

// Removes everything of a fleet that does not run: processes, namespaces, files. False: there was
// nothing.
bool clean_up(std::string_view fleet);

// Asks the fleet's process. Throws Failure: it does not run, it does not answer, it said no.
json::object ask_fleet(std::string_view fleet, const json::object& question, const Signals& signals,
                       tims::Duration timeout);

// The one that is meant: the name, or the only one that runs. Throws Failure.
std::string chosen_fleet(std::string_view name);

Failure no_such(std::string_view what, std::string_view name,
                std::span<const std::string_view> known);

// Throws Failure unless this process may make namespaces.
void need_root();

class Supervisor {
 public:
  // Takes the fleet's name on this host: throws Failure when one of that name runs.
  Supervisor(Context& context, const Plan& plan);
  // Takes everything down.
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  void bring_up();
  // Until the time, or until `sim down`; throws Interrupted on Ctrl-C.
  void serve(tims::Time until);
  // Programs that ended by themselves and were not content.
  [[nodiscard]] std::size_t failures() const { return failures_; }

 private:
  struct Action {
    std::string line;
    std::string host;
    tims::os::Command words;
    std::optional<tims::Duration> every;
  };

  void write_files() const;
  void write_state() const;
  void await_links();
  void start_clock();
  void tear_down();

  void fault(const Line& line, const tims::os::Command& words);
  void kill(const PlannedHost& host, std::string_view part);
  void start(const PlannedHost& host);
  void act(const Action& action);

  // The routers' part of lines' qualities: until they have accepted it.
  void request_faults(const Line& line, const LineState& before, const LineState& state);
  void request_all_faults(const PlannedHost& host);
  void inject_pending_faults();

  [[nodiscard]] tims::Time next_deadline(tims::Time until) const;
  void look_after_programs();
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
  // "robot1-main", "base": the router and its link, and what is pending.
  std::map<std::pair<std::string, std::string>, Quality> pending_faults_;
  tims::Time next_injection_{};
  std::string since_;
  std::size_t failures_ = 0;
};

}  // namespace timsctl::sim

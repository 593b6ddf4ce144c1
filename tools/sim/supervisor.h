// A fleet that runs: brings it up, does what its script and `timsctl sim` say, takes it down.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "os/file.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/cli/service.h"
#include "tools/sim/network.h"
#include "tools/sim/programs.h"

namespace timsctl::sim {

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
  void owe(const Line& line, const LineState& before, const LineState& state);
  void owe_all(const PlannedHost& host);
  void pay_debts();

  [[nodiscard]] tims::Time next_deadline(tims::Time until) const;
  void wait(tims::Time deadline);
  void look_after_programs();
  void answer_question();
  json::object answer(const json::object& question);
  const PlannedHost& need_host(std::string_view name) const;
  const Line& need_line(std::string_view name) const;

  Context& context_;
  EventLines events_;
  const Plan& plan_;
  Network network_;
  Programs programs_;
  Routers routers_;
  tims::os::File control_;
  Asker asker_;  // of `sim down`: told when everything is down
  std::map<std::string, LineState, std::less<>> states_;
  std::multimap<tims::Time, Action> schedule_;
  // "robot1-main", "base": the router and its link, and what is owed.
  std::map<std::pair<std::string, std::string>, Quality> debts_;
  tims::Time next_payment_{};
  std::string since_;
  bool asked_to_end_ = false;
  std::size_t failures_ = 0;
};

}  // namespace timsctl::sim

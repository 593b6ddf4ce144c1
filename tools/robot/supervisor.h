// A robot that runs: its programs are started, heard, started again when they crash, and ended. And
// which robots run on this host: a folder for each, with the socket at which its supervisor
// listens.
#pragma once

#include <list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/connection.h"
#include "tools/cli/context.h"
#include "tools/cli/output.h"
#include "tools/cli/service.h"
#include "tools/robot/program.h"
#include "tools/robot/robot_file.h"

namespace timsctl::robot {

// Two robots of one name may run, at different routers: the name and what tells the router from
// others ("sim-1@5c0ffee5") are the key of everything below.
std::string key_of(std::string_view name, std::string_view router);
std::string_view name_of(std::string_view key);

std::string folder_of(std::string_view robot);
std::string control_socket(std::string_view robot);
std::string status_socket(std::string_view robot);  // where its components say how they are
std::string log_file(std::string_view robot);       // of one in the background

// Their keys, in order.
std::vector<std::string> running();
bool is_running(std::string_view robot);
// The key of the one called so, or that has this key: at this router if several have the name.
// Without a name: of the only one. Throws Failure.
std::string chosen(std::string_view name, std::string_view router);
// Throws Failure: it does not run, it does not answer.
json::object ask(std::string_view robot, const json::object& question, const Signals& signals,
                 tims::Duration timeout);

struct Deployment {
  std::string name;    // what `timsctl down` calls it
  std::string host;    // of the robot, whose components run here; empty: those without a host
  std::string folder;  // programs run there: the file's
  std::string router;  // theirs, as in $TIMS_ROUTER
  RobotText source;    // its text also for other hosts
};

class Supervisor {
 public:
  // Takes the name on this host: throws Failure when one of that name runs.
  Supervisor(Context& context, const Robot& robot, const Deployment& deployment);
  // Ends all programs.
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  // Starts all programs; returns when those of components are ready, or did not become so in time.
  void start();
  // Until the time, until `down`, or until `input` ends (-1: none); throws Interrupted on Ctrl-C.
  void serve(tims::Time until, int input = -1);
  // Programs that have ended and stay down.
  [[nodiscard]] std::size_t failures() const { return failures_; }

 private:
  void add(const Component& component, std::size_t number, const Deployment& deployment);
  void add(const Host& host, const Robot& robot, const Deployment& deployment);

  void wait(tims::Time deadline, int input = -1);
  void look_after_programs();
  void look_after(Program& program);
  void start_again(Program& program, tims::Time now);
  void take_end(Program& program, const Program::End& end);
  void take_notifications();
  [[nodiscard]] json::object report() const;
  json::object save(const json::object& question);
  [[nodiscard]] tims::Time next_start() const;
  [[nodiscard]] bool is_starting() const;
  void end_all();

  Context& context_;
  EventLines events_;
  std::string name_;
  std::string router_;
  std::string key_;  // of its folder
  RobotText source_;
  ControlServer control_;
  std::optional<StatusSocket> status_;
  std::list<Program> programs_;
  std::map<const Program*, std::size_t> components_;  // which of the file's it is
  bool ending_ = false;
  std::size_t failures_ = 0;
};

}  // namespace timsctl::robot

// The supervisor of a running robot: starts its programs, monitors them, restarts them after a
// crash, and stops them. Also the list of running robots on this host: each has a folder with the
// socket of its supervisor.
#pragma once

#include <list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "os/service_manager.h"
#include "tools/cli/context.h"
#include "tools/cli/control.h"
#include "tools/cli/output.h"
#include "tools/cli/service.h"
#include "tools/robot/program.h"
#include "tools/robot/robot_file.h"

namespace timsctl::robot {

// The robots that run on this host. Robots of the same name may run at different routers, so a key
// consists of the name and a hash of the router: "sim-1@5c0ffee5".
const Services& robots();
std::string key_of(std::string_view name, std::string_view router);
std::string log_file(std::string_view key);  // log of a robot in the background
// The key of the robot with this name or key; if several have the name, of the one at this router.
// Without a name: of the only robot. Throws Failure.
std::string chosen(std::string_view name, std::string_view router);

struct Deployment {
  std::string name;  // name for `timsctl down`
  std::string
      host;  // the host of the robot whose components run here; empty: components without a host
  std::string folder;  // working folder of the programs: the folder of the file
  std::string router;  // router of the programs, as in $TIMS_ROUTER
  RobotText source;    // the text is also sent to other hosts
};

class Supervisor {
 public:
  // Reserves the name on this host. Throws Failure if a robot of that name runs.
  Supervisor(Context& context, const Robot& robot, const Deployment& deployment);
  // Stops all programs.
  ~Supervisor();
  Supervisor(const Supervisor&) = delete;
  Supervisor& operator=(const Supervisor&) = delete;

  // Starts all programs and returns when the components are ready or the time is over.
  void start();
  // Reports to the service manager that the robot is ready, then runs until the time, until `down`,
  // or until `input` ends (-1: none). Throws Interrupted on Ctrl-C.
  void serve(tims::Time until, int input = -1);
  // The number of programs that have ended and are not restarted.
  [[nodiscard]] std::size_t failures() const { return failures_; }

 private:
  Program& add(std::size_t number);
  Program& add(const Host& host);

  void wait(tims::Time deadline, int input = -1);
  void look_after_programs();
  void look_after(Program& program);
  void write_lines(Program& program, tims::Time now);
  void start_again(Program& program, tims::Time now);
  void take_end(Program& program, const Program::End& end);
  void take_notifications();
  void report_state(const Program& program);
  [[nodiscard]] std::string status_of(const Program& program) const;
  [[nodiscard]] json::object report() const;
  json::object save(const json::object& question);
  json::object reload();
  void end(const std::vector<Program*>& gone);
  [[nodiscard]] std::vector<std::string> names(State state) const;
  [[nodiscard]] tims::Time next_start() const;
  [[nodiscard]] bool is_starting() const;
  void end_all();

  Context& context_;
  EventLines events_;
  Robot robot_;
  Deployment deployment_;  // with the text that was read last
  std::string key_;        // of its folder
  ControlServer control_;
  StatusSocket status_;
  tims::os::ServiceManager manager_;  // of this program
  std::list<Program> programs_;
  std::map<const Program*, std::string> ends_;        // how programs have ended last
  std::map<const Program*, std::size_t> components_;  // index of the component in the file
  bool ending_ = false;
  std::size_t failures_ = 0;
};

}  // namespace timsctl::robot

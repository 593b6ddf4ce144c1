// The agent of a host: answers the questions of PROTOCOL.md, and does what its change needs. Times
// and messages come from main.cpp.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/configuration/effects.h"
#include "tools/configuration/fleet.h"
#include "tools/configuration/folder.h"
#include "tools/configuration/host_change.h"
#include "tools/configuration/installed_programs.h"
#include "tools/configuration/robot_check.h"
#include "tools/configuration/store.h"

namespace timsctl::configuration {

inline constexpr std::size_t kQuestionMax = 256U << 10;

// The router of this host, as its status states it.
struct RouterIdentity {
  std::string name;
  json::object address;  // {"name", "raw"}
  std::string widths;
};

class Agent {
 public:
  // `least_window`: that may be asked for, from kWindowMin to kWindow. `log`: what people should
  // see of changes. Throws Failure: the record or the files cannot be read.
  Agent(tims::Time now, const Folder& folder, const Store& store, const Effects& effects,
        tims::Duration least_window, std::function<void(const std::string&)> log);

  void set_router(RouterIdentity router) { router_ = std::move(router); }

  // The body of the answer to a question of another program; `from`: its address, "0x01010001".
  // After the answer was sent, call go_on().
  std::string answer(tims::Time now, std::string_view question, const std::string& from);
  // Steps that take time: programs are restarted.
  void go_on(tims::Time now);
  [[nodiscard]] tims::Time next_timeout() const;

  // --- other agents
  struct Peer {
    std::string agent;  // "0x01010001"
    std::string question;
  };
  std::vector<Peer> questions_to_peers(tims::Time now);
  // Answers without the number that was asked with are ignored: anybody can send them.
  void take_answer(tims::Time now, std::string_view answer, const std::string& from);

 private:
  json::object answer_or_throw(tims::Time now, const json::object& question,
                               const std::string& from);
  json::object list(tims::Time now) const;
  json::object get(const json::object& question) const;
  json::object describe(const json::object& question);
  json::object history(const json::object& question) const;
  json::object generation(const json::object& question) const;
  json::object check(const json::object& question);
  json::object fleet(const json::object& question);
  json::object state(tims::Time now) const;
  json::object lock(tims::Time now, const json::object& question);
  json::object apply(tims::Time now, const json::object& question);
  json::object undo(tims::Time now, const json::object& question);
  json::object peer(tims::Time now, const json::object& question, const std::string& from);

  [[nodiscard]] Texts files() const;
  std::vector<Finding> findings(const Texts& before, const Texts& after);
  json::object begin(tims::Time now, const json::object& question, const Texts& before,
                     const Texts& after);
  // Keeps files that were edited by hand as a generation.
  void keep_found(const Texts& files);
  // Steps until the next one that takes time. False: one failed.
  void do_steps(tims::Time now, bool all);
  void do_step(tims::Time now, const Step& step);
  void report(tims::Time now, const std::string& text);

  const Folder& folder_;
  const Store& store_;
  const Effects& effects_;
  const tims::Duration least_window_;
  std::function<void(const std::string&)> log_;
  HostChange change_;
  RouterIdentity router_{};
  json::array done_;
  InstalledPrograms programs_{};
  std::map<std::string, std::string> asked_;  // numbers of questions to other agents
  State reported_ = State::kIdle;
};

}  // namespace timsctl::configuration

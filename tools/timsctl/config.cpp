// timsctl config diff, apply, confirm, undo, history, budget: the configuration files of the hosts
// of a fleet, through their agents (tools/configuration/PROTOCOL.md).
#include <algorithm>
#include <deque>
#include <iostream>
#include <map>

#include <fmt/format.h>
#include <unistd.h>

#include "base/measure.h"
#include "os/clock.h"
#include "os/environment.h"
#include "os/file.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/cli/random_id.h"
#include "tools/configuration/rollout.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/config_edit.h"

namespace timsctl {
namespace {

using namespace std::chrono_literals;
using configuration::Rollout;

// An agent may start programs to learn their parameters.
constexpr tims::Duration kAgentWorks = 20s;
constexpr tims::Duration kAskAgain = 500ms;
constexpr tims::Duration kHostPatience = 60s;  // until a host has restarted its programs

// The agent has the mailbox beside its router.
tims::Address agent_of(tims::Address router) { return tims::Address(router.raw() + 1); }

// A host of the fleet with its agent.
struct ConfigHost {
  std::string name;  // of its router
  tims::Address agent{};
  json::array edits{};  // of PROTOCOL.md
  json::object checked{};
};

// The connection may be lost and made anew; questions go over the newest.
class Agents {
 public:
  explicit Agents(Context& context) : context_(context) { reconnect(); }

  void reconnect() {
    connection_.reset();
    connection_ = context_.connect();
  }

  // Throws Failure.
  json::object ask(tims::Address agent, const json::object& question) {
    AdminClient client(*connection_, context_.signals, context_.options.timeout, agent);
    const bool is_quick = text_at(question, "ask") == "conf_state";
    try {
      return client.ask(question, is_quick ? tims::Duration{} : kAgentWorks);
    } catch (const Failure& failure) {
      if (failure.code != "no_such_router") throw;
      throw Failure(Exit::kNoSuch, "no_agent",
                    fmt::format("no configuration agent at {}", agent.to_string(widths())),
                    "start tims-agent on the host of this router");
    }
  }
  json::object ask(const ConfigHost& host, const json::object& question) {
    return ask(host.agent, question);
  }

  // The router of this name; empty: that of -H or -r.
  ConfigHost host(const std::string& name) {
    const AdminClient own = context_.admin(*connection_);
    AdminClient admin = name.empty() ? own : own.at(find_router(own, name));
    const json::object status = admin.ask({{"ask", "status"}});
    const auto router = router_address(status);
    if (!router) throw Failure(Exit::kVersion, "version", "the router does not state its address");
    return {.name = text_at(status, "name"), .agent = agent_of(*router)};
  }

  // All hosts that can be reached and have an agent.
  std::vector<ConfigHost> all() {
    std::vector<ConfigHost> hosts;
    const json::object routers = walk_fleet(context_.admin(*connection_));
    for (const json::object& router : objects(items_of(routers)))
      if (const auto address = router_address(router); address && text_at(router, "state") == "up")
        hosts.push_back({.name = text_at(router, "name"), .agent = agent_of(*address)});
    return hosts;
  }

  // Null: there is no such file.
  json::value hash_of(const ConfigHost& host, const std::string& name) {
    const json::object list = ask(host, {{"ask", "conf_list"}});
    for (const json::object& file : objects(items_of(list, "files")))
      if (text_at(file, "file") == name) return file.at("hash");
    return nullptr;
  }

  // The texts of all files, by name.
  std::map<std::string, json::value> texts(const ConfigHost& host) {
    std::map<std::string, json::value> all;
    const json::object list = ask(host, {{"ask", "conf_list"}});
    for (const json::object& file : objects(items_of(list, "files"))) {
      const std::string name = text_at(file, "file");
      all[name] = ask(host, {{"ask", "conf_get"}, {"file", name}}).at("text");
    }
    return all;
  }

  [[nodiscard]] tims::AddressWidths widths() const { return connection_->widths(); }

 private:
  Context& context_;
  std::unique_ptr<Connection> connection_;
};

// --- edits

json::object whole_text(const ConfigEdit& edit, const json::value& base) {
  auto text = tims::os::read_file(edit.source);
  if (!text) throw Failure(Exit::kNoSuch, "no_such_file", text.error().detail());
  return {{"file", edit.file}, {"base", base}, {"text", std::move(*text)}};
}

// The hosts that the edits of the command line change.
std::vector<ConfigHost> hosts_of(const std::vector<std::string>& arguments, Agents& agents) {
  std::vector<ConfigHost> hosts;
  std::map<std::string, std::size_t> places;
  std::map<std::pair<std::size_t, std::string>, json::value> bases;
  for (const std::string& argument : arguments) {
    const ConfigEdit edit = parse_config_edit(argument);
    if (!places.contains(edit.router)) {
      ConfigHost host = agents.host(edit.router);
      const auto known = std::ranges::find(hosts, host.agent, &ConfigHost::agent);
      places[edit.router] = static_cast<std::size_t>(known - hosts.begin());
      if (known == hosts.end()) hosts.push_back(std::move(host));
    }
    const std::size_t place = places[edit.router];
    ConfigHost& host = hosts[place];
    const bool is_new = !bases.contains({place, edit.file});
    json::value& base = bases[{place, edit.file}];
    if (is_new) base = agents.hash_of(host, edit.file);
    if (edit.path.empty()) {
      host.edits.push_back(whole_text(edit, base));
      continue;
    }
    const bool goes_on = !host.edits.empty() &&
                         text_at(host.edits.back().as_object(), "file") == edit.file &&
                         host.edits.back().as_object().contains("operations");
    if (!goes_on)
      host.edits.push_back(
          json::object{{"file", edit.file}, {"base", base}, {"operations", json::array()}});
    host.edits.back().as_object()["operations"].as_array().push_back(operation_of(edit));
  }
  return hosts;
}

std::string problem_line(const json::object& problem) {
  const bool is_error = text_at(problem, "severity") == "error";
  const std::string place =
      number_or_zero(problem, "line") > 0
          ? fmt::format(":{}:{}", text_at(problem, "line"), text_at(problem, "column"))
          : "";
  return fmt::format("{}{}: {}{}\n", text_at(problem, "file"), place,
                     is_error ? "" : "warning: ", text_at(problem, "text"));
}

std::string checked_text(const std::vector<ConfigHost>& hosts, bool colour) {
  std::string text;
  for (const ConfigHost& host : hosts) {
    if (hosts.size() > 1) text += paint(host.name, Tone::kBold, colour) + "\n";
    for (const json::object& file : objects(items_of(host.checked, "files"))) {
      text += diff_in_colour(text_at(file, "diff"), colour);
      for (const json::value& sentence : items_of(file, "sentences"))
        text.append("  ").append(sentence.as_string()).append("\n");
    }
    for (const json::object& problem : objects(items_of(host.checked, "problems")))
      text += problem_line(problem);
  }
  return text;
}

// Whether all hosts would accept their edits.
bool check(std::vector<ConfigHost>& hosts, Agents& agents) {
  bool ok = true;
  for (ConfigHost& host : hosts) {
    host.checked = agents.ask(host, {{"ask", "conf_check"}, {"edits", host.edits}});
    ok = ok && text_at(host.checked, "ok") == "true";
  }
  return ok;
}

// All files of all hosts as they shall be, for conf_fleet.
json::array fleet_files(const std::vector<ConfigHost>& changed, Agents& agents,
                        const Context& context) {
  json::array all;
  for (const ConfigHost& host : agents.all()) {
    std::map<std::string, json::value> texts;
    try {
      texts = agents.texts(host);
    } catch (const Failure& failure) {
      context.out.detail(fmt::format("{}: {}", host.name, failure.message));
      continue;
    }
    const auto edited = std::ranges::find(changed, host.agent, &ConfigHost::agent);
    if (edited != changed.end())
      for (const json::object& file : objects(items_of(edited->checked, "files")))
        texts[text_at(file, "file")] = file.at("text");
    json::array files;
    for (const auto& [name, text] : texts)
      if (text.is_string()) files.push_back(json::object{{"file", name}, {"text", text}});
    all.push_back(json::object{{"host", host.name}, {"files", std::move(files)}});
  }
  return all;
}

json::object check_fleet(const std::vector<ConfigHost>& changed, Agents& agents,
                         const Context& context, bool measured) {
  const ConfigHost first = changed.empty() ? agents.host("") : changed.front();
  return agents.ask(first, {{"ask", "conf_fleet"},
                            {"hosts", fleet_files(changed, agents, context)},
                            {"measured", measured}});
}

// --- apply

std::string user_name() {
  const std::string user = tims::os::environment("USER");
  return fmt::format("{}@{}", user.empty() ? std::to_string(::getuid()) : user,
                     tims::os::host_name());
}

std::string_view sentence_of(Rollout::Ask ask) {
  switch (ask) {
    case Rollout::Ask::kLock:
      return "locking";
    case Rollout::Ask::kApply:
      return "writing";
    case Rollout::Ask::kWait:
      return "restarting what changed";
    case Rollout::Ask::kVerify:
      return "reached over a new connection";
    case Rollout::Ask::kConfirm:
      return "confirming";
    case Rollout::Ask::kSettle:
      return "waiting for the other hosts";
    case Rollout::Ask::kUndo:
      return "going back";
    default:
      return "";
  }
}

class Apply {
 public:
  Apply(Context& context, Agents& agents, std::vector<ConfigHost> hosts)
      : context_(context), agents_(agents), hosts_(std::move(hosts)), rollout_(hosts_.size()) {}

  Exit run() {
    bool interrupted = false;
    while (!rollout_.is_over()) {
      try {
        step();
      } catch (const Interrupted&) {
        // A second Ctrl-C: the hosts go back by themselves.
        if (std::exchange(interrupted, true)) throw;
        context_.signals.forget();
        context_.out.note("interrupted: all hosts go back");
        rollout_.stop("interrupted");
      }
      if (left_to_confirm_) break;
    }
    report();
    if (interrupted) return Exit::kInterrupted;
    return rollout_.is_kept() ? Exit::kDone : Exit::kNo;
  }

 private:
  void step() {
    const Rollout::Question question = rollout_.next();
    if (question.ask == Rollout::Ask::kReconnect) return reconnect();
    if (question.ask == Rollout::Ask::kConfirm && question.host == 0 && !is_wanted()) return;
    if (!(question == told_)) {
      told_ = question;
      since_ = tims::os::now();
      if (!sentence_of(question.ask).empty())
        context_.out.note(
            fmt::format("{}: {}", hosts_[question.host].name, sentence_of(question.ask)));
    }
    try {
      const json::object answer = agents_.ask(hosts_[question.host], question_of(question));
      take(question.ask, answer);
    } catch (const Failure& failure) {
      lost(question.ask, failure);
    }
  }

  json::object question_of(const Rollout::Question& question) const {
    json::object asked{{"change", change_}, {"who", user_name()}};
    switch (question.ask) {
      case Rollout::Ask::kLock:
        asked["ask"] = "conf_lock";
        break;
      case Rollout::Ask::kApply: {
        json::array others;
        for (const ConfigHost& host : hosts_)
          if (host.agent != hosts_[question.host].agent) others.emplace_back(host.agent.to_hex());
        asked["ask"] = "conf_apply";
        asked["why"] = context_.options.why;
        asked["window_s"] = base::seconds(context_.options.window);
        asked["edits"] = hosts_[question.host].edits;
        asked["others"] = std::move(others);
        break;
      }
      case Rollout::Ask::kConfirm:
        asked["ask"] = "conf_confirm";
        break;
      case Rollout::Ask::kUndo:
        asked["ask"] = "conf_undo";
        break;
      case Rollout::Ask::kUnlock:
        asked["ask"] = "conf_unlock";
        break;
      default:
        return {{"ask", "conf_state"}};
    }
    return asked;
  }

  void take(Rollout::Ask ask, const json::object& answer) {
    const std::string state = text_at(answer, "state");
    const bool is_ours = text_at(answer, "change") == change_;
    const bool is_last = text_at(answer, "last.change") == change_;
    const std::string reason = text_at(answer, is_ours ? "reason" : "last.reason");
    switch (ask) {
      case Rollout::Ask::kWait:
      case Rollout::Ask::kVerify:
        if (is_ours && state == "waiting") return note_failures(answer);
        if (is_ours && state == "applying") return again();
        return rollout_.take(Rollout::Answer::kWentBack, reason);
      case Rollout::Ask::kSettle:
        if (is_ours && state != "going_back") return again();
        return is_last && text_at(answer, "last.outcome") == "confirmed"
                   ? rollout_.take(Rollout::Answer::kDone)
                   : rollout_.take(Rollout::Answer::kWentBack, reason);
      default:
        return rollout_.take(Rollout::Answer::kDone);
    }
  }

  // Programs that could not be restarted are a reason to look, not to go back.
  void note_failures(const json::object& answer) {
    if (told_.ask == Rollout::Ask::kVerify)
      for (const json::object& done : objects(items_of(answer, "done")))
        if (text_at(done, "ok") == "false")
          context_.out.note(
              fmt::format("warning: {}: {}", text_at(done, "what"), text_at(done, "text")));
    rollout_.take(Rollout::Answer::kDone);
  }

  void again() {
    rollout_.take(Rollout::Answer::kNotYet);
    context_.signals.sleep_until(tims::os::now() + kAskAgain);
  }

  // A host that restarts its router does not answer for a while.
  void lost(Rollout::Ask ask, const Failure& failure) {
    const bool may_come =
        ask == Rollout::Ask::kWait || ask == Rollout::Ask::kVerify || ask == Rollout::Ask::kSettle;
    const bool is_refusal = failure.exit == Exit::kNo || failure.exit == Exit::kDenied;
    if (may_come && !is_refusal && tims::os::now() < since_ + patience()) {
      context_.signals.sleep_until(tims::os::now() + kAskAgain);
      return reconnect_quietly();
    }
    rollout_.take(Rollout::Answer::kRefused,
                  fmt::format("{}: {}", hosts_[rollout_.next().host].name, failure.message));
  }

  // Shorter than the window, so that the others are told to go back before they do it by
  // themselves.
  [[nodiscard]] tims::Duration patience() const {
    return std::min(kHostPatience, context_.options.window * 2 / 3);
  }

  void reconnect_quietly() {
    try {
      agents_.reconnect();
    } catch (const Failure&) {
      // The next question says so.
    }
  }

  void reconnect() {
    const tims::Time deadline = tims::os::now() + patience();
    while (true) {
      try {
        agents_.reconnect();
        return rollout_.take(Rollout::Answer::kDone);
      } catch (const Failure& failure) {
        if (tims::os::now() >= deadline)
          return rollout_.take(Rollout::Answer::kRefused, failure.message);
      }
      context_.signals.sleep_until(tims::os::now() + kAskAgain);
    }
  }

  // Whether to confirm now.
  bool is_wanted() {
    if (context_.options.yes) return true;
    if (::isatty(STDIN_FILENO) == 0 || context_.out.json()) {
      left_to_confirm_ = true;
      return false;
    }
    fmt::print(stderr, "The change is in force. Keep it? It goes back in {} otherwise [y/N] ",
               base::human_duration(base::seconds(context_.options.window)));
    std::string line;
    std::getline(std::cin, line);
    if (line == "y" || line == "yes") return true;
    rollout_.stop("not kept");
    return false;
  }

  void report() {
    json::array names;
    for (const ConfigHost& host : hosts_) names.emplace_back(host.name);
    const std::string_view outcome = left_to_confirm_     ? "waiting"
                                     : rollout_.is_kept() ? "confirmed"
                                                          : "went_back";
    if (context_.out.json())
      context_.out.write(json::object{{"schema", "tims/config_apply/1"},
                                      {"change", change_},
                                      {"outcome", outcome},
                                      {"reason", rollout_.failure()},
                                      {"hosts", std::move(names)}});
    if (left_to_confirm_)
      context_.out.note(fmt::format("in force; goes back in {} unless `timsctl config confirm {}`",
                                    base::human_duration(base::seconds(context_.options.window)),
                                    change_));
    else if (rollout_.is_kept())
      context_.out.note(fmt::format("change {} is kept on all hosts", change_));
    else
      context_.out.note(fmt::format("not kept: {}; {}", rollout_.failure(),
                                    rollout_.has_begun()
                                        ? "hosts that were changed go back by themselves"
                                        : "nothing was changed"));
  }

  Context& context_;
  Agents& agents_;
  std::vector<ConfigHost> hosts_;
  Rollout rollout_;
  std::string change_ = random_id();
  Rollout::Question told_{};
  tims::Time since_{};
  bool left_to_confirm_ = false;
};

// Leaves of the tree before their super routers.
void sort_hosts(std::vector<ConfigHost>& hosts, const json::object& fleet) {
  std::vector<std::string> order;
  for (const json::value& name : items_of(fleet, "order")) order.emplace_back(name.as_string());
  std::ranges::stable_sort(hosts, {}, [&](const ConfigHost& host) {
    return std::ranges::find(order, host.name) - order.begin();
  });
}

// Problems between hosts, of which at least one is in the change.
json::array fleet_errors(const std::vector<ConfigHost>& hosts, const json::object& fleet) {
  json::array errors;
  for (const json::object& problem : objects(items_of(fleet, "problems")))
    if (text_at(problem, "severity") == "error" &&
        std::ranges::find(hosts, text_at(problem, "host"), &ConfigHost::name) != hosts.end())
      errors.push_back(problem);
  return errors;
}

json::object checked_json(const std::vector<ConfigHost>& hosts, bool ok) {
  json::array items;
  for (const ConfigHost& host : hosts) items.push_back(host.checked);
  return {{"schema", "tims/config_diff/1"}, {"ok", ok}, {"items", std::move(items)}};
}

// The hosts of the change that is under way at the host of -H, and the change.
std::pair<std::vector<ConfigHost>, std::string> pending_hosts(Context& context, Agents& agents) {
  const ConfigHost first = agents.host("");
  const json::object state = agents.ask(first, {{"ask", "conf_state"}});
  const auto& arguments = context.options.arguments;
  const std::string change = text_at(state, "change");
  if (change.empty() || (!arguments.empty() && arguments.front() != change))
    throw Failure(Exit::kNoSuch, "no_such_change",
                  fmt::format("no such change is under way at {}", first.name),
                  "`timsctl config history` shows what happened");
  std::vector<ConfigHost> hosts{first};
  for (const json::value& other : items_of(state, "others"))
    if (const auto agent = tims::Address::parse(std::string(other.as_string())))
      hosts.push_back({.name = agent->to_string(agents.widths()), .agent = *agent});
  return {hosts, change};
}

Exit tell_all(Context& context, const std::string& ask, std::string_view done) {
  Agents agents(context);
  const auto [hosts, change] = pending_hosts(context, agents);
  // Nobody is told to keep a change that another host does not have.
  if (ask == "conf_confirm")
    for (const ConfigHost& host : hosts) {
      const json::object state = agents.ask(host, {{"ask", "conf_state"}});
      if (text_at(state, "change") != change)
        throw Failure(Exit::kNo, "not_confirmed",
                      fmt::format("{} does not have this change", host.name),
                      "it goes back everywhere");
    }
  json::array states;
  for (const ConfigHost& host : hosts)
    states.push_back(agents.ask(host, {{"ask", ask}, {"change", change}}));
  if (context.out.json())
    context.out.write(json::object{
        {"schema", "tims/config_change/1"}, {"change", change}, {"items", std::move(states)}});
  context.out.note(fmt::format("change {}: {} on {} host{}", change, done, hosts.size(),
                               hosts.size() == 1 ? "" : "s"));
  return Exit::kDone;
}

constexpr Column kHistory[] = {{"GENERATION", "generation"},
                               {"TIME", "time"},
                               {"WHO", "who"},
                               {"WHY", "why"},
                               {"OUTCOME", "outcome"},
                               {"REASON", "reason"},
                               {"CHANGE", "change", Cell::kText, true}};

constexpr Column kBudget[] = {{"HOST", "host"},
                              {"LINK", "link"},
                              {"CAP/s", "rate_bytes_per_s", Cell::kBytes},
                              {"WORST/s", "worst_bytes_per_s", Cell::kBytes},
                              {"OF CAP", "worst_share", Cell::kPercent},
                              {"NOW/s", "measured_bytes_per_s", Cell::kBytes},
                              {"OF CAP", "measured_share", Cell::kPercent},
                              {"LEVEL", "level"}};

}  // namespace

Exit config_diff(Context& context) {
  Agents agents(context);
  std::vector<ConfigHost> hosts = hosts_of(context.options.arguments, agents);
  const bool ok = check(hosts, agents);
  context.out.write(checked_json(hosts, ok),
                    [&] { return checked_text(hosts, context.out.look().colour); });
  return ok ? Exit::kDone : Exit::kNo;
}

Exit config_apply(Context& context) {
  Agents agents(context);
  std::vector<ConfigHost> hosts = hosts_of(context.options.arguments, agents);
  const bool ok = check(hosts, agents);
  if (!context.out.json()) context.out.write(checked_text(hosts, context.out.look().colour));
  if (!ok) {
    if (context.out.json()) context.out.write(checked_json(hosts, false));
    context.out.note("nothing was changed");
    return Exit::kNo;
  }
  const json::object fleet = check_fleet(hosts, agents, context, false);
  if (const json::array errors = fleet_errors(hosts, fleet); !errors.empty()) {
    std::string text;
    for (const json::object& error : objects(errors))
      text += text_at(error, "host") + ": " + problem_line(error);
    throw Failure(Exit::kNo, "refused", text.substr(0, text.size() - 1), "nothing was changed");
  }
  sort_hosts(hosts, fleet);
  return Apply(context, agents, std::move(hosts)).run();
}

Exit config_confirm(Context& context) { return tell_all(context, "conf_confirm", "confirmed"); }

Exit config_undo(Context& context) {
  if (!context.options.generation) return tell_all(context, "conf_undo", "goes back");
  Agents agents(context);
  const ConfigHost host = agents.host("");
  const std::string change = random_id();
  (void)agents.ask(host, {{"ask", "conf_undo"},
                          {"to", *context.options.generation},
                          {"change", change},
                          {"who", user_name()},
                          {"why", context.options.why.empty()
                                      ? fmt::format("back to {}", *context.options.generation)
                                      : context.options.why},
                          {"window_s", base::seconds(context.options.window)}});
  const tims::Time deadline = tims::os::now() + kHostPatience;
  while (context.options.yes) {
    try {
      agents.reconnect();
      (void)agents.ask(host, {{"ask", "conf_confirm"}, {"change", change}});
      break;
    } catch (const Failure& failure) {
      if (failure.code == "no_such_change" || tims::os::now() >= deadline) throw;
    }
    context.signals.sleep_until(tims::os::now() + kAskAgain);
  }
  if (context.out.json())
    context.out.write(json::object{{"schema", "tims/config_change/1"}, {"change", change}});
  context.out.note(
      context.options.yes
          ? fmt::format("the files of generation {} are in force", *context.options.generation)
          : fmt::format("in force; goes back in {} unless `timsctl config confirm {}`",
                        base::human_duration(base::seconds(context.options.window)), change));
  return Exit::kDone;
}

Exit config_history(Context& context) {
  Agents agents(context);
  json::object answer = agents.ask(
      agents.host(""), {{"ask", "conf_history"}, {"limit", context.options.count.value_or(20)}});
  json::array items = std::move(item_array(answer));
  return show_list(context, "tims/conf_history/1", std::move(items), kHistory);
}

Exit config_budget(Context& context) {
  Agents agents(context);
  const json::object fleet = check_fleet({}, agents, context, true);
  const bool red =
      std::ranges::any_of(objects(items_of(fleet, "links")),
                          [](const json::object& link) { return text_at(link, "level") == "red"; });
  if (context.out.json()) {
    context.out.write(fleet);
  } else {
    for (const json::object& problem : objects(items_of(fleet, "problems")))
      context.out.note(text_at(problem, "host") + ": " + problem_line(problem));
    context.out.write(render_items(items_of(fleet, "links"), kBudget, context.out.look()));
  }
  return red ? Exit::kNo : Exit::kDone;
}

}  // namespace timsctl

#include "tools/configuration/agent.h"

#include <algorithm>
#include <filesystem>
#include <ranges>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/measure.h"
#include "base/text.h"
#include "router/config/options.h"
#include "tools/cli/random_id.h"
#include "tools/configuration/answers.h"
#include "tools/configuration/differences.h"
#include "tools/configuration/questions.h"

namespace timsctl::configuration {
namespace {

namespace fs = std::filesystem;

Texts router_files(const Texts& all) {
  Texts files;
  for (const auto& file : all)
    if (!is_robot_file(file.first)) files.insert(file);
  return files;
}

// The greatest real-time priority that programs of this user may have.
int real_time_max() {
  if (::geteuid() == 0) return 99;  // whatever its limit
  struct rlimit limit {};
  if (::getrlimit(RLIMIT_RTPRIO, &limit) != 0 || limit.rlim_max == RLIM_INFINITY) return 99;
  return static_cast<int>(std::min<rlim_t>(limit.rlim_max, 99));
}

std::string now_text() {
  return base::rfc3339(
      std::chrono::time_point_cast<base::WallTime::duration>(std::chrono::system_clock::now()));
}

}  // namespace

Agent::Agent(tims::Time now, const Folder& folder, const Store& store, const Effects& effects,
             tims::Duration least_window, std::function<void(const std::string&)> log)
    : folder_(folder),
      store_(store),
      effects_(effects),
      least_window_(least_window),
      log_(std::move(log)),
      change_(now, value_or_fail(store.load(), "the record of the agent")) {
  (void)value_or_fail(folder_.read(), folder_.path());
  report(now, "continued after a restart");
  do_steps(now, true);
}

// --- reading

Texts Agent::files() const { return need(folder_.read(), "cannot_read"); }

json::object Agent::list(tims::Time now) const {
  json::array items;
  for (const auto& [name, text] : files()) {
    json::object row{{"file", name},
                     {"kind", is_robot_file(name) ? "robot" : "router"},
                     {"bytes", text.size()},
                     {"hash", hash_of(text)}};
    if (is_robot_file(name)) {
      const robot::Robot robot = robot::read_robot({name, text}, fs::path(name).stem()).robot;
      row["robot"] = robot.name;
      row["system"] = robot.system;
      row["running"] = effects_.is_running(name);
    }
    items.push_back(std::move(row));
  }
  const tims::config::Config router = load_router(files()).config;
  return {{"schema", "tims/conf_list/1"},
          {"folder", folder_.path()},
          {"router",
           json::object{{"name", router_.name},
                        {"address", router_.address},
                        {"system", router.router.system},
                        {"id", router.router.id},
                        {"role", base::trimmed(tims::config::to_toml(router.router.role), "\"")}}},
          {"widths", router_.widths},
          {"generation", change_.record().current},
          {"files", std::move(items)},
          {"change", state(now)}};
}

json::object Agent::get(const json::object& question) const {
  const std::string name = file_in(question);
  const Texts all = files();
  const auto found = all.find(name);
  if (found == all.end()) throw Refuse{"no_such_file", name + " is not there"};
  json::object row{{"schema", "tims/conf_get/1"},
                   {"file", name},
                   {"kind", is_robot_file(name) ? "robot" : "router"},
                   {"text", found->second},
                   {"hash", hash_of(found->second)}};
  append_values({name, found->second}, row);
  return row;
}

json::object Agent::describe(const json::object& question) {
  const std::string program = text_at(question, "program");
  const json::object* described = programs_.describe(program);
  if (described == nullptr)
    throw Refuse{"no_such_program",
                 base::printable(program) + " is no program of RACK on this host"};
  json::object made = *described;
  made["schema"] = "tims/description/1";
  return made;
}

json::object Agent::history(const json::object& question) const {
  const auto limit = static_cast<std::size_t>(
      std::clamp(number_at(question, "limit").value_or(kGenerationsKept), 1.0, 1000.0));
  json::array items;
  const std::vector<Item>& all = change_.record().items;
  for (auto item = all.rbegin(); item != all.rend() && items.size() < limit; ++item) {
    json::object row = configuration::to_json(*item);
    const auto files = store_.files(item->generation);
    row["files"] = files_json(files ? *files : Texts{}, false);
    row["current"] = item->generation == change_.record().current;
    items.push_back(std::move(row));
  }
  return {{"schema", "tims/conf_history/1"}, {"items", std::move(items)}};
}

json::object Agent::generation(const json::object& question) const {
  const Generation wanted = generation_in(question, "generation");
  const Item* item = change_.record().find(wanted);
  if (item == nullptr)
    throw Refuse{"no_such_generation", fmt::format("generation {} is not kept", wanted)};
  json::object row = configuration::to_json(*item);
  row["schema"] = "tims/conf_generation/1";
  row["files"] = files_json(need(store_.files(wanted), "no_such_generation"), true);
  return row;
}

json::object Agent::state(tims::Time now) const {
  const Record& record = change_.record();
  json::object made{{"schema", "tims/conf_state/1"},
                    {"generation", record.current},
                    {"state", name_of(change_.state(now))},
                    {"left_s", base::seconds(change_.left(now))},
                    {"window_min_s", base::seconds(least_window_)},
                    {"done", done_},
                    {"last", nullptr}};
  if (const Item* item = change_.pending()) {
    made["change"] = item->change;
    made["who"] = item->who;
    made["why"] = item->why;
    made["window_s"] = base::seconds(change_.window());
    made["others"] = json::array(item->others.begin(), item->others.end());
    made["reason"] = record.pending->reason;
  } else if (const std::string holder = change_.lock_holder(now); !holder.empty()) {
    made["who"] = holder;
    made["change"] = change_.locking_change();
  }
  for (const auto& item : std::views::reverse(record.items)) {
    if (item.outcome == Outcome::kPending) continue;
    made["last"] = configuration::to_json(item);
    break;
  }
  return made;
}

// --- checking

// Of the router's files together, and of each robot file, as far as the edits touch them.
std::vector<Finding> Agent::findings(const Texts& before, const Texts& after) {
  std::vector<Finding> all;
  if (router_files(before) != router_files(after))
    for (const tims::config::Problem& problem : load_router(after).problems)
      all.push_back({.file = problem.at.file,
                     .line = problem.at.line,
                     .column = problem.at.column,
                     .text = problem.text});
  const fs::path robots = folder_.path_of("robots");
  const Surroundings around{
      .describe = [this](const std::string& program) { return programs_.find(program); },
      .has_file = [&](const std::string& name) { return fs::exists(robots / name); },
      .files_beside =
          [&](const std::string& name) {
            std::vector<std::string> names;
            std::error_code error;
            for (const auto& entry : fs::directory_iterator((robots / name).parent_path(), error))
              names.push_back(entry.path().filename());
            return names;
          },
      .priority_max = real_time_max()};
  for (const auto& [name, text] : after) {
    const auto old = before.find(name);
    if (!is_robot_file(name) || (old != before.end() && old->second == text)) continue;
    const auto found = check_robot({name, text}, around);
    all.insert(all.end(), found.begin(), found.end());
  }
  return all;
}

json::object Agent::check(const json::object& question) {
  const Texts before = files();
  const Texts after = edited(question, before);
  // Without edits: of all that is deployed.
  const std::vector<Finding> found = findings(before == after ? Texts{} : before, after);
  json::array changed;
  json::array effects;
  const Describe describe = [this](const std::string& program) { return programs_.find(program); };
  const auto effect = [&](std::string_view what, std::string_view file, std::string_view does) {
    effects.push_back(json::object{{"what", what}, {"file", file}, {"does", does}});
  };
  const auto text_in = [](const Texts& texts, const std::string& name) {
    const auto text = texts.find(name);
    return text == texts.end() ? std::string() : text->second;
  };
  std::vector<std::string> router_sentences;
  bool restarts = false;
  if (!has_errors(found))
    for (const auto& change :
         tims::config::changes(load_router(before).config, load_router(after).config)) {
      router_sentences.push_back(change.to_string());
      restarts = restarts || !change.reloadable;
    }
  Texts names = before;
  names.insert(after.begin(), after.end());
  for (const auto& [name, unused] : names) {
    const std::string old = text_in(before, name);
    const std::string now = text_in(after, name);
    const bool same = old == now && before.contains(name) == after.contains(name);
    if (same) continue;
    const TextDifference made = difference(name, old, now);
    std::vector<std::string> sentences;
    if (is_robot_file(name) && !has_errors(found)) {
      const RobotDifference robot = robot_difference(old, now, name, describe);
      sentences = robot.sentences;
      const bool running = effects_.is_running(name);
      for (const auto& [component, does] : robot.effects)
        effect(component, name, running ? does : "none");
    } else if (!is_robot_file(name)) {
      sentences = std::exchange(router_sentences, {});
      if (!sentences.empty()) effect("router", name, restarts ? "restart" : "reload");
    }
    json::object row{{"file", name},
                     {"hash", after.contains(name) ? json::value(hash_of(now)) : json::value()},
                     {"text", after.contains(name) ? json::value(now) : json::value()},
                     {"added", made.added},
                     {"removed", made.removed},
                     {"diff", made.diff},
                     {"sentences", json::array(sentences.begin(), sentences.end())}};
    if (after.contains(name)) append_values({name, now}, row);
    changed.push_back(std::move(row));
  }
  return {{"schema", "tims/conf_check/1"},
          {"ok", !has_errors(found)},
          {"problems", to_json(found)},
          {"files", std::move(changed)},
          {"effects", std::move(effects)}};
}

json::object Agent::fleet(const json::object& question) {
  const std::vector<FleetHost> hosts = hosts_in(question);
  FleetReport report =
      check_fleet(hosts, [this](const std::string& program) { return programs_.find(program); });
  if (text_at(question, "measured") == "true") effects_.measure(report.links);
  json::array edges;
  for (const Edge& edge : report.edges) edges.push_back(to_json(edge));
  json::array links;
  for (const LinkBudget& link : report.links) links.push_back(to_json(link));
  return {{"schema", "tims/conf_fleet/1"},
          {"ok", !has_errors(report.findings)},
          {"problems", to_json(report.findings)},
          {"order", json::array(report.order.begin(), report.order.end())},
          {"edges", std::move(edges)},
          {"links", std::move(links)}};
}

// --- changing

json::object Agent::lock(tims::Time now, const json::object& question) {
  refuse_if(change_.lock(now, change_id(question), checked_text(question, "who"),
                         seconds_in(question, "for_s", 60, 1, 600)));
  return state(now);
}

json::object Agent::apply(tims::Time now, const json::object& question) {
  const Texts before = files();
  const Texts after = edited(question, before);
  if (before == after) throw Refuse{"bad_argument", "these edits change nothing"};
  return begin(now, question, before, after);
}

json::object Agent::begin(tims::Time now, const json::object& question, const Texts& before,
                          const Texts& after) {
  Item item{.change = change_id(question),
            .who = checked_text(question, "who"),
            .why = checked_text(question, "why")};
  const tims::Duration window = seconds_in(question, "window_s", base::seconds(kWindow),
                                           base::seconds(least_window_), base::seconds(kWindowMax));
  item.others = others_in(question);
  refuse_if(change_.may_begin(now, item.change));
  const std::vector<Finding> found = findings(before, after);
  if (has_errors(found))
    throw Refuse{"refused", sentence_of(*std::ranges::find(found, true, &Finding::is_error)),
                 found};
  keep_found(before);
  item.time = now_text();
  if (const auto kept = store_.keep(change_.next(), after); !kept)
    throw Refuse{"cannot_write", kept.error().detail()};
  done_.clear();
  refuse_if(change_.begin(now, std::move(item), window));
  do_steps(now, false);
  report(now, "");
  return state(now);
}

void Agent::keep_found(const Texts& files) {
  const auto current = store_.files(change_.record().current);
  if (change_.record().current != 0 && current && *current == files) return;
  if (const auto kept = store_.keep(change_.next(), files); !kept)
    throw Refuse{"cannot_write", kept.error().detail()};
  change_.found(now_text(), "");
  do_steps({}, false);
}

json::object Agent::undo(tims::Time now, const json::object& question) {
  if (at_path(question, "to") == nullptr) {
    refuse_if(change_.undo(now, change_id(question), "undone"));
    do_steps(now, false);
    return state(now);
  }
  const Generation wanted = generation_in(question, "to");
  if (change_.record().find(wanted) == nullptr)
    throw Refuse{"no_such_generation", fmt::format("generation {} is not kept", wanted)};
  const Texts after = need(store_.files(wanted), "no_such_generation");
  const Texts before = files();
  if (before == after)
    throw Refuse{"bad_argument", fmt::format("the files are those of generation {}", wanted)};
  return begin(now, question, before, after);
}

// Stops at steps that take time, unless `all`.
void Agent::do_steps(tims::Time now, bool all) {
  while (const Step* next = change_.step()) {
    if (next->kind == Step::Kind::kApply && !all) return;
    const Step step = *next;
    try {
      do_step(now, step);
      change_.done(now);
    } catch (const Refuse& refuse) {
      log_("error: " + refuse.message);
      change_.failed(now, refuse.message);
    }
  }
}

void Agent::do_step(tims::Time, const Step& step) {
  const auto check = [](const tims::Result<void>& done) {
    if (!done) throw Refuse{"cannot_write", done.error().detail()};
  };
  switch (step.kind) {
    case Step::Kind::kSave:
      return check(store_.save(change_.record()));
    case Step::Kind::kWrite:
      return check(folder_.write(need(store_.files(step.generation), "cannot_read")));
    case Step::Kind::kApply:
      done_ = effects_.apply(need(store_.files(step.from), "cannot_read"),
                             need(store_.files(step.generation), "cannot_read"));
  }
}

// One line whenever the state changes: nobody is to wonder why a robot behaves in another way.
void Agent::report(tims::Time now, const std::string& text) {
  const State state = change_.state(now);
  if (state == reported_) return;
  const bool was_under_way = reported_ != State::kIdle && reported_ != State::kLocked;
  reported_ = state;
  if (const Item* item = change_.pending()) {
    const std::string& reason = change_.record().pending->reason;
    log_(fmt::format("{}change {} of {} ({}): {}{}", state == State::kGoingBack ? "WARNING: " : "",
                     item->generation, item->who, item->why, name_of(state),
                     reason.empty() ? text.empty() ? "" : ", " + text : ", " + reason));
  } else if (was_under_way && !change_.record().items.empty()) {
    const Item& last = change_.record().items.back();
    log_(last.outcome == Outcome::kWentBack
             ? fmt::format(
                   "WARNING: change {} of {} went back: {}; the files are those of generation "
                   "{} again",
                   last.generation, last.who, last.reason, change_.record().current)
             : fmt::format("change {} of {} is confirmed", last.generation, last.who));
  }
}

void Agent::go_on(tims::Time now) {
  report(now, "");
  do_steps(now, true);
  report(now, "");
  change_.on_timeout(now);
  report(now, "");
  do_steps(now, true);
  report(now, "");
}

tims::Time Agent::next_timeout() const { return change_.next_timeout(); }

// --- other agents

std::vector<Agent::Peer> Agent::questions_to_peers(tims::Time now) {
  std::vector<Peer> all;
  for (const HostChange::Peer& peer : change_.peers_to_ask(now)) {
    std::string& number = asked_[peer.agent];
    number = random_id();
    all.push_back({peer.agent, json::serialize(json::object{{"ask", "conf_peer"},
                                                            {"change", peer.change},
                                                            {"standing", name_of(peer.own)},
                                                            {"number", number}})});
  }
  return all;
}

json::object Agent::peer(tims::Time now, const json::object& question, const std::string& from) {
  const auto standing = standing_of(text_at(question, "standing"));
  const std::string change = change_id(question);
  if (!standing) throw Refuse{"bad_argument", "standing is missing"};
  change_.heard(now, from, change, *standing);
  do_steps(now, false);
  return {{"schema", "tims/conf_peer/1"},
          {"change", change},
          {"number", text_at(question, "number")},
          {"standing", name_of(change_.standing(change))}};
}

void Agent::take_answer(tims::Time now, std::string_view answer, const std::string& from) {
  boost::system::error_code error;
  const json::value value = json::parse(answer, error);
  const json::object* object = error ? nullptr : value.if_object();
  const auto asked = asked_.find(from);
  if (object == nullptr || asked == asked_.end() || text_at(*object, "number") != asked->second)
    return;
  asked_.erase(asked);
  if (const auto standing = standing_of(text_at(*object, "standing")))
    change_.answered(now, from, text_at(*object, "change"), *standing);
}

// --- questions

std::string Agent::answer(tims::Time now, std::string_view question, const std::string& from) {
  json::object made;
  try {
    boost::system::error_code error;
    const json::value value = json::parse(question, error);
    const json::object* object = error ? nullptr : value.if_object();
    if (question.size() > kQuestionMax) throw Refuse{"too_big", "a question has at most 256 KiB"};
    if (object == nullptr) throw Refuse{"bad_json", "not a JSON object"};
    made = answer_or_throw(now, *object, from);
  } catch (const Refuse& refuse) {
    made["error"] = json::object{{"code", refuse.code}, {"message", refuse.message}, {"hint", ""}};
    if (!refuse.findings.empty()) made["problems"] = to_json(refuse.findings);
  }
  made["host"] = router_.name;
  std::string text = json::serialize(made);
  if (text.size() <= kQuestionMax) return text;
  return json::serialize(
      json::object{{"host", router_.name},
                   {"error", json::object{{"code", "too_big"},
                                          {"message", "the answer would have more than 256 KiB"},
                                          {"hint", "ask about fewer files"}}}});
}

json::object Agent::answer_or_throw(tims::Time now, const json::object& question,
                                    const std::string& from) {
  const std::string ask = text_at(question, "ask");
  if (ask == "conf_list") return list(now);
  if (ask == "conf_get") return get(question);
  if (ask == "conf_options") return options_json();
  if (ask == "conf_describe") return describe(question);
  if (ask == "conf_programs") return programs_.list();
  if (ask == "conf_state") return state(now);
  if (ask == "conf_history") return history(question);
  if (ask == "conf_generation") return generation(question);
  if (ask == "conf_check") return check(question);
  if (ask == "conf_fleet") return fleet(question);
  if (ask == "conf_lock") return lock(now, question);
  if (ask == "conf_apply") return apply(now, question);
  if (ask == "conf_undo") return undo(now, question);
  if (ask == "conf_peer") return peer(now, question, from);
  if (ask == "conf_unlock") {
    refuse_if(change_.unlock(now, change_id(question)));
    return state(now);
  }
  if (ask == "conf_confirm") {
    refuse_if(change_.confirm(now, change_id(question)));
    do_steps(now, false);
    return state(now);
  }
  if (ask.empty()) throw Refuse{"bad_question", "no \"ask\" in the question"};
  throw Refuse{"unknown_question", "this agent does not know \"" + base::printable(ask) + "\""};
}

}  // namespace timsctl::configuration

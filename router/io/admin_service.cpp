#include "router/io/admin_service.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <set>
#include <utility>

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text.h"
#include "router/config/options.h"
#include "router/io/reports.h"
#include "wire/header.h"

namespace tims::io {
namespace {

using base::valid_utf8;
using link::Links;

namespace json = boost::json;

constexpr std::size_t kEnvelopeBytes = 4096;  // size of an answer without its items
constexpr std::size_t kStatusEvents = 5;

// Collects items as text until the answer is full.
class Page {
 public:
  // `fields_bytes`: size of the other fields of the answer, if there are more than a few.
  explicit Page(std::size_t fields_bytes = 0)
      : bytes_max_(kAnswerBytesMax - kEnvelopeBytes - fields_bytes) {}

  // Returns false when there is no room; the item was not added.
  bool add(const json::object& item) {
    const std::string text = json::serialize(item);
    if (items_.size() + text.size() + 1 > bytes_max_) return false;
    items_.append(count_ == 0 ? "" : ",").append(text);
    ++count_;
    return true;
  }
  [[nodiscard]] std::size_t size() const { return count_; }

  // `{"schema": ...}` followed by the items.
  [[nodiscard]] std::string put_into(const json::object& frame) const {
    std::string text = json::serialize(frame);
    text.pop_back();
    return text.append(R"(,"items":[)").append(items_).append("]}");
  }

 private:
  const std::size_t bytes_max_;
  std::string items_;
  std::size_t count_ = 0;
};

// The common fields of all answers.
json::object answer_frame(const AdminSource& source, const Clocks& clocks,
                          std::string_view schema) {
  return {{"schema", schema},
          {"router", valid_utf8(source.config().router.name)},
          {"time", base::rfc3339(clocks.wall)},
          {"partial", false}};
}

json::object error_json(const QuestionError& error) {
  json::object out{{"code", error.code}, {"message", valid_utf8(error.message)}};
  if (!error.hint.empty()) out["hint"] = error.hint;
  return {{"error", std::move(out)}};
}

// --- actions

Links::Action action_of(std::string_view action) {
  if (action == "up") return Links::Action::kUp;
  return action == "down" ? Links::Action::kDown : Links::Action::kReset;
}

// Names of the routers at the other ends. With `places`, a router whose name is unknown is
// represented by its configured address.
std::vector<std::string_view> link_names(const AdminSource& source, bool places) {
  std::vector<std::string_view> names;
  if (const Links* links = source.links())
    links->for_each([&](const link::Link& link) {
      const std::string_view name = link.peer().name.view();
      if (places || !name.empty()) names.push_back(name.empty() ? link.settings().to : name);
    });
  return names;
}

// A route over a link that does not exist would silently drop messages.
std::optional<QuestionError> no_link_for_route(const AdminSource& source, std::string_view name) {
  const auto known = link_names(source, false);
  if (std::ranges::find(known, name) != known.end()) return std::nullopt;
  std::string hint = "this router has no links: [[link]] in its configuration";
  if (const auto near = base::nearest(name, known))
    hint = fmt::format("did you mean {}?", *near);
  else if (!known.empty())
    hint = fmt::format("there are {}", fmt::join(known, ", "));
  return QuestionError{"no_such_link", fmt::format("no link to a router \"{}\"", name), hint};
}

QuestionError not_done(std::string why) { return {"not_done", std::move(why)}; }

QuestionError no_link(const AdminSource& source, std::string_view name) {
  const auto known = link_names(source, true);
  return not_done(known.empty() ? fmt::format("no link to \"{}\"; there are none", name)
                                : fmt::format("no link to \"{}\"; there are links to {}", name,
                                              fmt::join(known, ", ")));
}

std::optional<QuestionError> change_routes(const Question& question, AdminSource& source) {
  std::vector<core::StaticRoute> routes = source.router().static_routes();
  const std::size_t gone = std::erase_if(routes, [&](const core::StaticRoute& route) {
    return route.text.view() == question.pattern &&
           (question.link.empty() || route.via.view() == question.link);
  });
  if (question.ask == Ask::kRouteAdd) {
    if (question.link.empty())
      return not_done("\"via\" is missing: the name of a router on a link");
    if (auto wrong = no_link_for_route(source, question.link)) return wrong;
    if (routes.size() >= kStaticRoutesMax)
      return not_done("there are " + std::to_string(kStaticRoutesMax) + " static routes already");
    routes.push_back(
        {question.match, std::string_view(question.pattern), std::string_view(question.link)});
  } else if (gone == 0) {
    return not_done("no static route for \"" + question.pattern + "\"");
  }
  source.set_static_routes(routes);
  return std::nullopt;
}

// Executes the question's request; returns the error if it fails.
std::optional<QuestionError> carry_out(const Question& question, AdminSource& source) {
  switch (question.ask) {
    case Ask::kLinkDo:
      if (source.act_on_link(question.link, action_of(question.action))) return std::nullopt;
      return no_link(source, question.link);
    case Ask::kFault:
      if (!source.config().sim.faults)
        return not_done(
            "this router injects no faults: set sim.faults = true in its configuration and "
            "reload it");
      if (source.inject_faults(question.link, question.faults)) return std::nullopt;
      return no_link(source, question.link);
    default:
      return change_routes(question, source);
  }
}

// "link robot3 down", "route_add Ladar(3/*) robot3", "fault"
std::string change_text(const Question& question) {
  std::string text(name(question.ask));
  for (const std::string* part : {&question.pattern, &question.link, &question.action})
    if (!part->empty()) text.append(" ").append(*part);
  return text;
}

std::string act(const Question& question, core::ClientId asker, AdminSource& source,
                const Clocks& clocks) {
  if (const auto problem = carry_out(question, source))
    return json::serialize(error_json(*problem));
  source.changed(clocks.now, asker, change_text(question));
  json::object out = answer_frame(source, clocks, "tims/done/1");
  out["done"] = true;
  return json::serialize(out);
}

// Whom the asker may let log in: himself.
std::optional<Person> person_asking(core::ClientId asker, const AdminSource& source) {
  const core::Client* client = source.router().client(asker);
  if (client == nullptr) return std::nullopt;
  if (const Person* person = source.person(client->info.port, client->info.token)) return *person;
  if (client->info.port != core::PortKind::kLocal) return std::nullopt;
  // With unix.everybody, other users may look.
  const bool is_trusted = !source.config().unix.everybody || client->info.uid == 0 ||
                          client->info.uid == source.process({}).uid;
  policy::Subject proven = client->info.subject;
  std::erase(proven.identities, "port:local");
  return Person{.name = fmt::format("uid {}", client->info.uid),
                .rights = rights_up_to(is_trusted ? Right::kConfigure : Right::kLook),
                .proven = std::move(proven)};
}

std::string make_login(const Question& question, core::ClientId asker, AdminSource& source,
                       const Clocks& clocks) {
  auto person = person_asking(asker, source);
  const Right wanted = right_of(question.right).value_or(Right::kNone);
  if (!person || !has(person->rights, std::max(wanted, Right::kLook)))
    return json::serialize(
        error_json({"denied",
                    "a login is given to programs of the router's host, and to users of the fleet "
                    "for the rights they have",
                    "run timsctl web on the router's host"}));
  if (wanted != Right::kNone) person->rights = rights_up_to(wanted);
  const std::string right(name(highest(person->rights)));
  const auto secret = source.make_login(clocks.now, *person, question.bearer);
  if (!secret)
    return json::serialize(
        error_json({"not_done", "this router has no keys, so nobody has to log in",
                    "open http://127.0.0.1:8080 on its host; see security.keys"}));
  json::object out = answer_frame(source, clocks, "tims/login_made/1");
  out["user"] = base::valid_utf8(person->name);
  out["right"] = right;
  out[question.bearer ? "bearer" : "token"] = *secret;
  out["http"] = source.process(clocks.now).http;
  return json::serialize(out);
}

// A subsystem router has the leases of the router above it, and gives none.
std::optional<QuestionError> lease_elsewhere(const Question& question, core::ClientId asker,
                                             const core::Router& router) {
  const core::Client* above = router.client(router.uplink());
  const bool is_below = router.settings().role == core::Role::kSubsystem && above != nullptr &&
                        above->info.link.role == core::Role::kSystem;
  if (is_below && asker != above->id)
    return QuestionError{
        "lease_elsewhere", "the router above this one has the driving leases of its robot",
        fmt::format("ask {}", above->info.link.router.to_string(router.settings().widths))};
  if (question.mailbox && !is_below)
    return QuestionError{"bad_argument", "\"mailbox\" is for the router above a subsystem router"};
  return std::nullopt;
}

// Who drives a robot. `request`: the header of the question.
std::optional<QuestionError> change_lease(const Question& question, core::ClientId asker,
                                          const Header& request, AdminSource& source, Time now) {
  if (auto elsewhere = lease_elsewhere(question, asker, source.router())) return elsewhere;
  const core::DrivingLease holder{.robot = *question.robot,
                                  .holder = std::string_view(question.holder),
                                  .mailbox = question.mailbox.value_or(request.src),
                                  .stick = question.stick.value_or(Address())};
  // Its messages come from the owner of its mailbox.
  const core::Table::Entry* owned =
      question.mailbox ? source.router().find(*question.mailbox) : nullptr;
  const core::LeaseResult result =
      source.change_lease(now, owned == nullptr ? asker : owned->owner, question.lease, holder);
  if (result == core::LeaseResult::kDone) return std::nullopt;
  const core::DrivingLease* other = source.router().leases().find(*question.robot);
  const std::string robot = fmt::format("robot {}", *question.robot);
  if (result == core::LeaseResult::kTaken)
    return QuestionError{"lease_taken", fmt::format("{} drives {}", other->holder.view(), robot),
                         "take_over takes the lease from its holder; ask it first"};
  if (result == core::LeaseResult::kTooMany) return not_done("there are too many driving leases");
  return QuestionError{"lease_not_held",
                       other == nullptr ? fmt::format("the driving lease of {} has ended", robot)
                                        : fmt::format("{} drives {}", other->holder.view(), robot),
                       "take it again"};
}

std::string lease_text(const Question& question, const AdminSource& source, const Clocks& clocks) {
  json::object out = answer_frame(source, clocks, "tims/done/1");
  out["done"] = true;
  out["left_s"] = question.lease == core::LeaseVerb::kRelease
                      ? json::value()
                      : json::value(base::seconds(core::DrivingLeases::kTime));
  return json::serialize(out);
}

void merge(json::object& into, const json::object& fields) {
  for (const auto& [key, value] : fields) into[key] = value;
}

// A page continues with the number of the first item that had no room: for a link its slot;
// numbers of missing routers are greater.
constexpr std::uint64_t kMissingFirst = 1ULL << 32;

std::uint64_t first_number(const Question& question) {
  std::uint64_t first = 0;
  std::from_chars(question.after.data(), question.after.data() + question.after.size(), first);
  return first;
}

template <typename Item>
void fill_page(json::object& out, const link::Links* links, const Question& question, Page& page,
               Item item) {
  const std::uint64_t first = first_number(question);
  bool full = false;
  if (links == nullptr) return;
  links->for_each([&](const link::Link& link) {
    if (full || link.slot() < first) return;
    if (!question.link.empty() && link.peer().name.view() != question.link &&
        link.settings().to != question.link)
      return;
    full = page.size() == question.limit || !page.add(item(link));
    if (full) out["next"] = std::to_string(link.slot());
  });
}

// --- answers

const core::EventLog& log_of(const Question& question, const core::Router& router) {
  return question.audit ? router.audit() : router.events();
}

class Answerer {
 public:
  Answerer(const Question& question, const AdminSource& source, const Clocks& clocks)
      : question_(question), source_(source), clocks_(clocks), router_(source.router()) {}

  std::string answer() {
    const json::object fields = answer_fields();
    return page_ ? page_->put_into(fields) : json::serialize(fields);
  }

 private:
  json::object answer_fields() {
    switch (question_.ask) {
      case Ask::kStatus:
        return status();
      case Ask::kClients:
        return clients();
      case Ask::kRoutes:
        return mailboxes("tims/route/1", false);
      case Ask::kRoute:
        return route();
      case Ask::kMailboxes:
        return mailboxes("tims/mailbox/1", true);
      case Ask::kStats:
        return stats();
      case Ask::kEvents:
        return events();
      case Ask::kConfig:
        return config();
      case Ask::kPing:
        return ping();
      case Ask::kRouters:
        return routers();
      case Ask::kLinks:
        return links();
      case Ask::kFleet:
        return fleet();
      case Ask::kNewest:
        return question_.of ? newest_value() : newest_values();
      case Ask::kStreams:
        return streams();
      case Ask::kLeases:
        return leases();
      case Ask::kRules:
        return rules();
      case Ask::kVerdict:
        return verdict();
      default:
        return {};  // handled by act() and change_lease()
    }
  }

  json::object frame(std::string_view schema) const {
    return answer_frame(source_, clocks_, schema);
  }

  json::object status() const {
    json::object out = frame("tims/status/1");
    const auto report = core::report_status(router_, clocks_.now);
    const ProcessReport process = source_.process(clocks_.now);
    merge(out, to_json(report, process));
    json::array recent;
    const std::uint64_t since = report.last_event - std::min(report.last_event, kStatusEvents);
    for (const core::Event& event :
         core::report_events(router_.events(), since, kStatusEvents).items)
      recent.push_back(to_json(event, clocks_, widths()));
    out["events"] = std::move(recent);
    return out;
  }

  json::object clients() {
    json::object out = frame("tims/client/1");
    std::uint32_t after = 0;
    std::from_chars(question_.after.data(), question_.after.data() + question_.after.size(), after);
    Page& page = page_.emplace();
    const auto found =
        core::report_clients(router_, clocks_.now, core::ClientId{after}, question_.limit);
    bool more = found.more;
    for (const core::ClientReport& report : found.items) {
      json::object item = to_json(report);
      item["queue_bytes"] = source_.queued_bytes(report.client.port, report.token);
      if (!page.add(item)) {
        more = true;
        break;
      }
      after = report.client.id.value;
    }
    if (more) out["next"] = std::to_string(after);
    return out;
  }

  json::object mailboxes(std::string_view schema, bool with_fill) {
    json::object out = frame(schema);
    std::optional<Address> after = Address::parse(question_.after);
    const auto found =
        core::report_mailboxes(router_, clocks_.now, question_.match, after, question_.limit);
    if (!with_fill) out["static"] = static_routes();
    Page& page = page_.emplace(with_fill ? 0 : json::serialize(out).size());
    std::optional<Address> next = found.more ? found.last : std::nullopt;
    for (const core::MailboxReport& report : found.items) {
      json::object item = to_json(report, widths());
      if (with_fill && report.owner.port == core::PortKind::kLocal)
        if (const auto fill = source_.fill(report.handle)) merge(item, to_json(*fill));
      if (!page.add(item)) {
        next = after;
        break;
      }
      after = report.address;
    }
    if (next) out["next"] = next->to_hex();
    return out;
  }

  // All routes added at run time; of a longer configured list only the beginning.
  [[nodiscard]] json::array static_routes() const {
    json::array routes;
    for (const core::StaticRoute& route : router_.static_routes()) {
      if (routes.size() == kStaticRoutesMax) break;
      routes.push_back({{"match", route.text.view()}, {"via", route.via.view()}});
    }
    return routes;
  }

  json::object route() const {
    json::object out = frame("tims/route_get/1");
    merge(out, to_json(core::report_route(router_, clocks_.now, *question_.to, question_.type,
                                          question_.from),
                       *question_.to, widths()));
    if (question_.from) out["from_registered"] = router_.find(*question_.from) != nullptr;
    return out;
  }

  json::object stats() {
    json::object out = frame("tims/stats/1");
    Page& page = page_.emplace();
    for (const core::CountReport& report : core::report_counts(router_)) page.add(to_json(report));
    const auto& classes = router_.settings().classes.from;
    out["classes"] = json::array(classes.begin(), classes.end());
    json::object events;
    for (const auto& report : core::report_event_counts(router_))
      events[core::name(report.kind)] = report.count;
    out["events"] = std::move(events);
    out["mailboxes"] = to_json(source_.mailbox_counts());
    return out;
  }

  json::object events() {
    json::object out = frame("tims/event/1");
    Page& page = page_.emplace();
    const core::EventLog& log = log_of(question_, router_);
    core::EventPage found{.items = {}, .last = log.last()};
    if (question_.since) found = core::report_events(log, *question_.since, question_.limit);
    std::uint64_t last = found.items.empty() ? found.last : 0;
    for (const core::Event& event : found.items) {
      if (!page.add(to_json(event, clocks_, widths()))) break;
      last = event.sequence;
    }
    out["epoch"] = epoch_text(source_.process(clocks_.now).epoch);
    out["last"] = last;
    out["lost"] = found.lost;
    return out;
  }

  json::object config() {
    json::object out = frame("tims/config/1");
    Page& page = page_.emplace();
    for (const config::Entry& entry : config::entries(source_.config())) {
      const auto origin = source_.origins().find(entry.key);
      const bool is_default = origin == source_.origins().end();
      const bool room =
          page.add({{"key", entry.key},
                    {"value", valid_utf8(config::to_toml(entry.get(source_.config())))},
                    {"origin", is_default ? "default" : valid_utf8(origin->second.to_string())},
                    {"reloadable", entry.option->reload == config::Reload::kYes}});
      if (!room) {
        out["partial"] = true;
        break;
      }
    }
    return out;
  }

  json::object ping() const {
    json::object out = frame("tims/ping/1");
    out["address"] = to_json(router_.settings().address, widths());
    out["epoch"] = epoch_text(source_.process(clocks_.now).epoch);
    if (!question_.pad.empty()) out["pad"] = question_.pad;
    return out;
  }

  json::object routers() {
    json::object out = frame("tims/router_list/1");
    const link::Links* links = source_.links();
    Page& page = page_.emplace();
    if (links != nullptr && question_.after.empty())
      page.add(to_json(links->self(), source_.process(clocks_.now)));
    fill_page(out, links, question_, page,
              [&](const link::Link& link) { return to_json(link, clocks_.now); });
    if (!out.contains("next")) add_missing(out, *page_);
    return out;
  }

  // Routers that have a link are reported with it, whatever its state.
  void add_missing(json::object& out, Page& page) const {
    std::set<Address> linked;
    if (const link::Links* links = source_.links())
      links->for_each([&](const link::Link& link) { linked.insert(link.peer().address()); });
    const std::uint64_t first = first_number(question_);
    router_.missing().for_each(clocks_.now, [&](const core::MissingRouter& missing) {
      const std::uint64_t number = kMissingFirst + missing.number;
      if (out.contains("next") || number < first || linked.contains(missing.router)) return;
      if (page.size() == question_.limit || !page.add(to_json(missing, widths(), clocks_.now)))
        out["next"] = std::to_string(number);
    });
  }

  json::object links() {
    json::object out = frame("tims/link/1");
    const link::Links* links = source_.links();
    Page& page = page_.emplace();
    fill_page(out, links, question_, page,
              [&](const link::Link& link) { return to_json(*links, link, router_, clocks_.now); });
    return out;
  }

  json::object fleet() {
    json::object out = frame("tims/fleet/1");
    out["fleet"] = valid_utf8(source_.config().fleet.name);
    const auto dds = source_.dds();
    out["dds"] = dds ? json::value(to_json(*dds)) : json::value();
    Page& page = page_.emplace();
    if (const link::Links* links = source_.links())
      for (const auto& [from, announcement] : links->fleet().routers())
        if (!page.add(to_json(*links, announcement))) out["partial"] = true;
    return out;
  }

  json::object newest_values() {
    json::object out = frame("tims/newest/1");
    page_.emplace();
    const core::NewestValues* newest = router_.newest();
    merge(out, to_json(newest == nullptr ? core::NewestValues::Counts() : newest->counts()));
    if (newest != nullptr)
      fill_page_of(out, newest->sorted(question_.match),
                   [&](const auto* value) { return to_json(*value, widths(), clocks_.now); });
    return out;
  }

  // With its body: bytes as hexadecimal digits, in the byte order of its sender.
  json::object newest_value() const {
    const core::NewestValues* newest = router_.newest();
    const auto* value = newest == nullptr ? nullptr : newest->find(*question_.of, question_.stream);
    if (value == nullptr)
      return error_json(
          {"none_kept",
           fmt::format("this router keeps no {} of {}", core::name(question_.stream),
                       question_.of->to_string(widths())),
           "a router keeps what passed it, of the streams that newest.streams lists"});
    json::object out = frame("tims/newest_value/1");
    merge(out, to_json(*value, widths(), clocks_.now));
    out["little_endian"] = value->header.body_order() == std::endian::little;
    out["body"] = base::to_hex(newest->body(*value));
    return out;
  }

  json::object streams() {
    json::object out = frame("tims/stream/1");
    fill_page_of(out, core::report_streams(router_, question_.match, question_.to),
                 [&](const core::StreamReport& report) { return to_json(report, widths()); });
    return out;
  }

  json::object leases() {
    json::object out = frame("tims/lease/1");
    fill_page_of(out, router_.leases().all(), [&](const core::DrivingLease& lease) {
      return to_json(lease, widths(), clocks_.now);
    });
    return out;
  }

  json::object rules() {
    json::object out = frame("tims/rule/1");
    if (router_.policy() != nullptr) out["replies"] = router_.policy()->replies();
    fill_page_of(out, core::report_rules(router_),
                 [](const core::RuleReport& report) { return to_json(report); });
    return out;
  }

  json::object verdict() const {
    const auto who = policy::Subject::parse(question_.who);
    auto query = policy::parse_type(
        question_.what, static_cast<std::uint16_t>(question_.to->fields(widths()).class_id));
    if (!who || !query || router_.policy() == nullptr)
      return error_json(
          {"bad_argument",
           !who ? fmt::format("\"{}\" is nobody that rules know", question_.who.substr(0, 64))
                : fmt::format("\"{}\" is no type of messages", question_.what.substr(0, 64)),
           R"(who: "user:guest", "uid:1000, gid:100", "router:base"; what: "move", "look", "21")"});
    query->dest = *question_.to;
    json::object out = frame("tims/verdict/1");
    merge(out, to_json(core::report_verdict(router_, *who, *query, question_.priority)));
    return out;
  }

  // A page of a list that is made for each question: it continues with the number of the first
  // item that had no room.
  template <typename List, typename Item>
  void fill_page_of(json::object& out, const List& list, Item item) {
    Page& page = page_.emplace();
    for (std::size_t i = first_number(question_); i < list.size(); ++i) {
      if (page.size() < question_.limit && page.add(item(list[i]))) continue;
      out["next"] = std::to_string(i);
      return;
    }
  }

  [[nodiscard]] const AddressWidths& widths() const { return router_.settings().widths; }

  const Question& question_;
  const AdminSource& source_;
  const Clocks& clocks_;
  const core::Router& router_;
  std::optional<Page> page_{};  // for answers with items
};

// --- origin of questions

std::string answer_text(const std::variant<Question, QuestionError>& question,
                        const AdminSource& source, const Clocks& clocks) {
  if (const auto* error = std::get_if<QuestionError>(&question))
    return json::serialize(error_json(*error));
  return Answerer(std::get<Question>(question), source, clocks).answer();
}

// A router numbers its events from 1 after every start: a number of another epoch is meaningless
// here.
std::variant<Question, QuestionError> read_question(std::string_view text,
                                                    const AdminSource& source, Time now) {
  auto read = parse_question(text, source.router().settings().widths);
  auto* question = std::get_if<Question>(&read);
  if (question != nullptr && question->since && !question->epoch.empty() &&
      question->epoch != epoch_text(source.process(now).epoch))
    question->since = 0;
  return read;
}

std::string_view text_of(const core::Message& request) {
  const auto body = request.body();
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes as the text they are
  return {reinterpret_cast<const char*>(body.data()), body.size()};
}

QuestionError denied() {
  return {"denied", "TCP and WebSocket clients have read-only access",
          "ask over the Unix socket of the router's host, or set tcp.admin = true at the router "
          "you ask"};
}

bool has(const std::vector<core::StaticRoute>& routes, const core::StaticRoute& route) {
  return std::ranges::any_of(routes, [&](const core::StaticRoute& other) {
    return other.text.view() == route.text.view() && other.via.view() == route.via.view();
  });
}

}  // namespace

std::vector<core::StaticRoute> reload_routes(const std::vector<core::StaticRoute>& running,
                                             const std::vector<core::StaticRoute>& before,
                                             const std::vector<core::StaticRoute>& after) {
  std::vector<core::StaticRoute> routes;
  for (const core::StaticRoute& route : after)
    if (!has(before, route) || has(running, route)) routes.push_back(route);
  for (const core::StaticRoute& route : running)
    if (!has(before, route) && !has(routes, route)) routes.push_back(route);
  return routes;
}

std::string answer_admin(std::string_view question, const AdminSource& source,
                         const Clocks& clocks) {
  auto read = read_question(question, source, clocks.now);
  const auto* checked = std::get_if<Question>(&read);
  if (checked != nullptr &&
      (acts(checked->ask) || drives(checked->ask) || makes_login(checked->ask)))
    read = QuestionError{"denied", "this interface is read-only", "ask with timsctl"};
  return answer_text(read, source, clocks);
}

// --- waiting questions

bool AdminService::has_room(core::ClientId from, const Header& request) {
  changed_ = true;
  const auto is_his = [&](const Waiting& waiting) { return waiting.asker == from; };
  if (std::ranges::count_if(waiting_, is_his) < static_cast<std::ptrdiff_t>(kPerClientMax))
    return true;
  refused_.push_back({from, request});
  return false;
}

void AdminService::deny(core::ClientId from, const core::Message& request, std::string_view rule) {
  if (!has_room(from, request.header)) return;
  waiting_.push_back(
      {.asker = from,
       .request = request.header,
       .question = QuestionError{"denied", fmt::format("the policy does not permit it: {}", rule),
                                 "`timsctl acl show` on the router's host lists its rules"}});
}

void AdminService::ask(Time now, core::ClientId from, const core::Message& request) {
  if (!has_room(from, request.header)) return;
  Waiting waiting{.asker = from,
                  .request = request.header,
                  .question = read_question(text_of(request), source_, now)};
  if (const auto* question = std::get_if<Question>(&waiting.question)) {
    waiting.deadline = now + question->wait;
    if (acts(question->ask) && !may_change(from)) waiting.question = denied();
  }
  // A question to the agent beside a router comes here only when it is refused.
  if (is_for_agent(request)) waiting.question = denied();
  waiting_.push_back(std::move(waiting));
}

bool AdminService::is_for_agent(const core::Message& request) const {
  return request.header.dest.fields(source_.router().settings().widths).local != 0;
}

bool AdminService::may_change(core::ClientId from) const {
  const core::Client* client = source_.router().client(from);
  if (const Person* person =
          client == nullptr ? nullptr : source_.person(client->info.port, client->info.token))
    return has(person->rights, Right::kConfigure);
  const bool guest = client != nullptr && (client->info.port == core::PortKind::kTcp ||
                                           client->info.port == core::PortKind::kWebSocket);
  return !guest || source_.config().tcp.admin;
}

bool AdminService::may_ask(core::ClientId from, const core::Message& request) const {
  if (may_change(from)) return true;
  if (is_for_agent(request)) return is_agent_reading(text_of(request));
  const auto read = parse_question(text_of(request), source_.router().settings().widths);
  const auto* question = std::get_if<Question>(&read);
  return question == nullptr || !acts(question->ask);
}

bool AdminService::is_due(const Waiting& waiting, Time now) const {
  const auto* question = std::get_if<Question>(&waiting.question);
  if (question == nullptr || question->ask != Ask::kEvents || !question->since) return true;
  const std::uint64_t last = log_of(*question, source_.router()).last();
  // Greater than the last number: it is from before a restart, and there is much to report.
  return last != *question->since || now >= waiting.deadline;
}

// Answers one question of each client in turn until the limit of the turn is reached; clients
// that were not served are first in the next turn.
void AdminService::answer(const Clocks& clocks, const Send& send) {
  changed_ = more_ = blocked_ = false;
  std::erase_if(waiting_, [&](const Waiting& waiting) {
    return source_.router().client(waiting.asker) == nullptr;
  });
  refuse(send);
  const std::size_t too_many = waiting_.size() - std::min(waiting_.size(), kWaitingMax);
  std::size_t bytes = 0;
  bool somebody_waits = false;
  std::vector<Waiting> still;
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    Waiting& waiting = waiting_[i];
    waiting.due = waiting.due || i < too_many || is_due(waiting, clocks.now);
    const bool due = waiting.due;
    const bool served = std::ranges::find(served_, waiting.asker) != served_.end();
    const bool reads = !due || can_take_more(waiting.asker);
    if (due && reads && !served && bytes < kTurnBytesMax) {
      bytes += send_answer(waiting, clocks, send);
      served_.push_back(waiting.asker);
      continue;
    }
    more_ = more_ || (due && reads);
    somebody_waits = somebody_waits || (due && reads && !served);
    blocked_ = blocked_ || (due && !reads);
    still.push_back(std::move(waiting));
  }
  waiting_ = std::move(still);
  if (!somebody_waits) served_.clear();
}

// Questions of a slow reader wait: no answer is generated before it has read the previous ones.
bool AdminService::can_take_more(core::ClientId asker) const {
  const core::Client& client = *source_.router().client(asker);
  return source_.queued_bytes(client.info.port, client.info.token) < kAnswerBytesMax;
}

void AdminService::refuse(const Send& send) {
  if (refused_.empty()) return;
  const std::string text = json::serialize(error_json(
      {"busy", fmt::format("{} questions of this client are not answered yet", kPerClientMax),
       "wait for their answers before sending more"}));
  auto& bytes = sent_.emplace_back(refused_.size() * (kHeaderSize + text.size()));
  std::span<std::byte> rest(bytes);
  for (const Refused& refused : refused_) {
    send_text(refused.asker, refused.request, text, rest.first(kHeaderSize + text.size()), send);
    rest = rest.subspan(kHeaderSize + text.size());
  }
  refused_.clear();
}

// The other routers of the robot refuse others, too. They forget a lease that is not renewed.
void AdminService::tell_below(const Question& question, const Header& request, const Send& send) {
  const core::Router& router = source_.router();
  const core::DrivingLease* lease = router.leases().find(*question.robot);
  const core::DrivingLease ended{.robot = *question.robot, .mailbox = request.src};
  const core::DrivingLease& told = lease == nullptr ? ended : *lease;
  json::object body{{"ask", "lease"},
                    {"robot", told.robot},
                    {"do", lease == nullptr ? "release" : "take_over"},
                    {"mailbox", told.mailbox.to_hex()}};
  if (lease != nullptr) body["name"] = valid_utf8(told.holder.view());
  if (told.stick.raw() != 0) body["stick"] = told.stick.to_hex();
  const std::string text = json::serialize(body);
  std::vector<Address> below;
  router.clients().for_each([&](const core::Client& client) {
    const auto& with = client.info.link;
    if (client.info.port == core::PortKind::kLink && with.kind == core::LinkKind::kSub &&
        with.role == core::Role::kSubsystem && with.system == told.robot)
      below.push_back(with.router);
  });
  for (const Address to : below) {
    auto& bytes = sent_.emplace_back(kHeaderSize + text.size());
    std::memcpy(bytes.data() + kHeaderSize, text.data(), text.size());
    core::Message message{.header = {.type = type::kAdminRequest,
                                     .priority = request.priority,
                                     .dest = to,
                                     .src = router.settings().address,
                                     .length = static_cast<std::uint32_t>(bytes.size())},
                          .bytes = bytes};
    wire::encode_header(message.header, message.bytes.first<kHeaderSize>());
    send({}, message);
  }
}

std::size_t AdminService::send_answer(const Waiting& waiting, const Clocks& clocks,
                                      const Send& send) {
  const auto* question = std::get_if<Question>(&waiting.question);
  const bool leases = question != nullptr && drives(question->ask);
  const auto refused =
      leases ? change_lease(*question, waiting.asker, waiting.request, source_, clocks.now)
             : std::nullopt;
  const std::string text = refused  ? json::serialize(error_json(*refused))
                           : leases ? lease_text(*question, source_, clocks)
                           : question != nullptr && makes_login(question->ask)
                               ? make_login(*question, waiting.asker, source_, clocks)
                           : question != nullptr && acts(question->ask)
                               ? act(*question, waiting.asker, source_, clocks)
                               : answer_text(waiting.question, source_, clocks);
  const std::size_t size = kHeaderSize + text.size();
  send_text(waiting.asker, waiting.request, text, sent_.emplace_back(size), send);
  if (leases && !refused) tell_below(*question, waiting.request, send);
  return size;
}

void AdminService::send_text(core::ClientId asker, const Header& request, std::string_view text,
                             std::span<std::byte> bytes, const Send& send) {
  std::memcpy(bytes.data() + kHeaderSize, text.data(), text.size());
  core::Message message{
      .header = wire::reply_to(request, type::kAdminReply, static_cast<std::uint32_t>(text.size())),
      .bytes = bytes};
  wire::encode_header(message.header, message.bytes.first<kHeaderSize>());
  send(asker, message);
}

Time AdminService::next_timeout() const {
  Time next = kNever;
  for (const Waiting& waiting : waiting_)
    if (!waiting.due) next = std::min(next, waiting.deadline);
  return next;
}

}  // namespace tims::io

#include "router/io/admin_answers.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <optional>
#include <set>

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>
#include <fmt/format.h>

#include "base/text.h"
#include "router/config/options.h"
#include "router/io/admin_actions.h"
#include "router/io/reports.h"

namespace tims::io {
namespace {

using base::valid_utf8;

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
    const std::uint64_t since =
        report.last_event - std::min<std::uint64_t>(report.last_event, kStatusEvents);
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
    for (const core::StaticRoute& route : router_.routes().all_static()) {
      if (routes.size() == kStaticRoutesMax) break;
      routes.push_back({{"match", route.text.view()}, {"via", route.via.view()}});
    }
    return routes;
  }

  // The type of messages that a question is about, or the right.
  [[nodiscard]] std::optional<policy::Query> asked_type() const {
    if (question_.what.empty()) return policy::Query{.type = question_.type};
    return policy::parse_type(question_.what,
                              static_cast<std::uint16_t>(question_.to->fields(widths()).class_id));
  }
  [[nodiscard]] std::string no_type() const {
    return fmt::format("\"{}\" is no type of messages", question_.what.substr(0, 64));
  }

  json::object route() const {
    const auto query = asked_type();
    if (!query)
      return error_json({"bad_argument", no_type(), R"(what: "move", "look", "change", "21")"});
    json::object out = frame("tims/route_get/1");
    merge(out, to_json(core::report_route(router_, clocks_.now, *question_.to, query->type,
                                          question_.from, query->right),
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
    fill_page(out, links, question_, page, [&](const link::Link& link) {
      return to_json(*links, link, router_, source_.faults_of(link), clocks_.now);
    });
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
    auto query = asked_type();
    if (!who || !query || router_.policy() == nullptr)
      return error_json(
          {"bad_argument",
           !who ? fmt::format("\"{}\" is nobody that rules know", question_.who.substr(0, 64))
                : no_type(),
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
    for (std::uint64_t i = first_number(question_); i < list.size(); ++i) {
      if (page.size() < question_.limit && page.add(item(list[static_cast<std::size_t>(i)])))
        continue;
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

}  // namespace

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

std::string error_text(const QuestionError& error) { return json::serialize(error_json(error)); }

std::variant<Question, QuestionError> read_question(std::string_view text,
                                                    const AdminSource& source, Time now) {
  auto read = parse_question(text, source.router().settings().widths);
  auto* question = std::get_if<Question>(&read);
  if (question != nullptr && question->since && !question->epoch.empty() &&
      question->epoch != epoch_text(source.process(now).epoch))
    question->since = 0;
  return read;
}
std::string answer_text(const Question& question, const AdminSource& source, const Clocks& clocks) {
  return Answerer(question, source, clocks).answer();
}

std::string answer_admin(std::string_view question, const AdminSource& source,
                         const Clocks& clocks) {
  const auto read = read_question(question, source, clocks.now);
  const auto* checked = std::get_if<Question>(&read);
  if (checked == nullptr) return error_text(std::get<QuestionError>(read));
  return effect(checked->ask) == Effect::kNone
             ? answer_text(*checked, source, clocks)
             : error_text({"denied", "this interface is read-only", "ask with timsctl"});
}

const core::EventLog& log_of(const Question& question, const core::Router& router) {
  return question.audit ? router.audit() : router.events();
}

}  // namespace tims::io

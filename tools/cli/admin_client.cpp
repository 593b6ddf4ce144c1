#include "tools/cli/admin_client.h"

#include <deque>
#include <map>

#include <boost/json/parse.hpp>

#include "base/text.h"
#include "os/clock.h"
#include "tools/cli/arguments.h"
#include "tools/cli/failure.h"

namespace timsctl {

namespace {

// Higher than that of data subscriptions (0), which may fill the mailbox; lower than that of
// messages between robot components.
constexpr std::uint8_t kPriority = 10;

json::object parse_answer(const Message& message, const std::string& where) {
  if (auto answer = json_of(message)) return std::move(*answer);
  throw Failure(Exit::kVersion, "version", where + ": the answer of the router is not JSON",
                "install timsctl and tims-router of the same version");
}

Exit exit_of(std::string_view code) {
  if (code.starts_with("no_such")) return Exit::kNoSuch;
  if (code == "denied") return Exit::kDenied;
  if (code == "unknown_question") return Exit::kVersion;
  return Exit::kNo;
}

void throw_error(const json::object& answer) {
  if (at_path(answer, "error") == nullptr) return;
  std::string code = text_at(answer, "error.code");
  const Exit exit = exit_of(code);
  throw Failure(exit, std::move(code), text_at(answer, "error.message"),
                text_at(answer, "error.hint"));
}

constexpr std::uint32_t kRouterClass = tims::class_id::kTims;

class FleetWalk {
 public:
  explicit FleetWalk(const AdminClient& first) : first_(first) {}

  json::object run() {
    visit(first_, {});
    while (!waiting_.empty()) {
      const std::string raw = waiting_.front();
      waiting_.pop_front();
      json::object& item = routers_[raw];
      if (text_at(item, "state") == "up") visit(first_.at(router_address(item)), raw);
    }
    json::array items;
    bool partial = false;
    for (const std::string& raw : order_) {
      json::object& item = routers_[raw];
      partial =
          partial || text_at(item, "state") != "up";  // the routers behind it are unknown, too
      items.push_back(std::move(item));
    }
    return {{"schema", "tims/router_list/1"}, {"partial", partial}, {"items", std::move(items)}};
  }

 private:
  // Asks one router; `raw` is its address, empty for the first.
  void visit(AdminClient router, const std::string& raw) {
    json::object answer;
    try {
      answer = router.ask({{"ask", "routers"}});
    } catch (const Failure& failure) {
      if (raw.empty()) throw;
      // A router that does not answer must not hide the others.
      routers_[raw]["state"] = "unreachable";
      routers_[raw]["trouble"] = failure.message;
      return;
    }
    std::string self = raw;
    for (const json::object& item : objects(items_of(answer))) {
      if (text_at(item, "kind") == "self")
        self = add_self(item);
      else if (!text_at(item, "address.raw").empty())
        add_neighbour(item, self);
    }
  }

  std::string add_self(const json::object& item) {
    std::string raw = text_at(item, "address.raw");
    json::object& known = place(raw);
    const bool first = order_.size() == 1;
    for (const auto& [key, value] : item)
      if (key != "kind" && key != "via") known[key] = value;
    if (first) {
      known["parent"] = nullptr;
      known["depth"] = 0;
      known["clock"] = json::object{{"offset_s", 0.0}, {"uncertainty_s", 0.0}};
      known["rtt_s"] = nullptr;
      known["kind"] = "self";
    }
    return raw;
  }

  void add_neighbour(const json::object& item, const std::string& at) {
    const std::string raw = text_at(item, "address.raw");
    const bool is_new = !routers_.contains(raw);
    json::object& known = place(raw);
    // A router with a link to it knows more than a router that reports it as missing.
    const auto is_missing = [](const json::object& it) { return text_at(it, "kind") == "missing"; };
    const bool better = (text_at(item, "state") == "up" && text_at(known, "state") == "down") ||
                        (is_missing(known) && !is_missing(item));
    if (!is_new && !better) return;
    const std::string behind = text_at(item, "behind.raw");
    const bool is_behind = behind != raw && routers_.contains(behind);
    const json::object& parent = routers_[is_behind ? behind : at];
    const json::value parents_clock = parent.contains("clock") ? parent.at("clock") : json::value();
    const std::string name = text_at(parent, "name");
    const double depth = number_or_zero(parent, "depth");
    known = item;
    // Only the neighbours of a router know its name.
    if (text_at(item, "name").empty()) known["name"] = text_at(item, "address.name");
    known["parent"] = name;
    known["depth"] = static_cast<int>(depth) + 1;
    known["clock"] = sum(parents_clock, item);
    waiting_.push_back(raw);
  }

  json::object& place(const std::string& raw) {
    if (!routers_.contains(raw)) order_.push_back(raw);
    return routers_[raw];
  }

  // Offsets add up along the path, and so do their uncertainties.
  static json::value sum(const json::value& parent, const json::object& item) {
    const auto offset = number_at(item, "clock.offset_s");
    if (!parent.is_object() || !offset) return nullptr;
    const json::object& base = parent.as_object();
    return json::object{{"offset_s", number_or_zero(base, "offset_s") + *offset},
                        {"uncertainty_s", number_or_zero(base, "uncertainty_s") +
                                              number_or_zero(item, "clock.uncertainty_s")}};
  }

  const AdminClient& first_;
  std::map<std::string, json::object> routers_;  // by raw address
  std::vector<std::string> order_;
  std::deque<std::string> waiting_;
};

// The router may not have read the message files of this host.
void name_classes_in(json::value& value) {
  if (json::array* items = value.if_array()) {
    for (json::value& item : *items) name_classes_in(item);
  } else if (json::object* object = value.if_object()) {
    for (auto& member : *object) name_classes_in(member.value());
  } else if (json::string* text = value.if_string()) {
    *text = with_class_names(std::string(*text));
  }
}

}  // namespace

std::optional<json::object> json_of(const Message& message) {
  const std::string_view text(reinterpret_cast<const char*>(message.body.data()),
                              message.body.size());
  boost::system::error_code error;
  json::value value = json::parse(text, error);
  if (error || !value.is_object()) return std::nullopt;
  name_classes_in(value);
  return std::move(value.get_object());
}

json::object AdminClient::ask(const json::object& question, tims::Duration patience) {
  if (const std::string match = text_at(question, "match"); !match.empty())
    (void)need_pattern(match, widths());
  json::object answer = ask_once(question, patience);
  json::object next = question;
  while (const json::value* after = at_path(answer, "next")) {
    next["after"] = *after;
    json::object page = ask_once(next, patience);
    json::array& items = item_array(answer);
    for (json::value& item : item_array(page)) items.push_back(std::move(item));
    answer.erase("next");
    if (const json::value* more = at_path(page, "next")) answer["next"] = *more;
  }
  return answer;
}

tims::Result<void> AdminClient::send(std::span<const std::byte> body, std::uint8_t seq_nr) {
  const tims::Envelope envelope{.dest = router_.value_or(tims::Address()),
                                .type = tims::type::kAdminRequest,
                                .priority = kPriority,
                                .seq_nr = seq_nr};
  return router_ ? connection_.send(envelope, body) : connection_.send_to_router(envelope, body);
}

std::string AdminClient::where() const {
  return router_ ? router_->to_string(widths()) : connection_.where();
}

json::object AdminClient::ask_once(const json::object& question, tims::Duration patience) {
  const std::string text = to_text(question);
  const auto bytes = std::as_bytes(std::span(text));
  const std::uint8_t seq_nr = connection_.next_seq_nr();
  const tims::Time asked = tims::os::now();
  const std::uint64_t losses = connection_.losses();
  if (auto sent = send(bytes, seq_nr); !sent) throw failure_of(sent.error(), where());
  while (auto message = receive(connection_, signals_, asked + timeout_ + patience, losses)) {
    const bool from_there = !router_ || message->header.src == *router_;
    if (message->header.seq_nr != seq_nr || !from_there) continue;
    if (message->header.type == tims::type::kNotAvailable)
      throw Failure(Exit::kNoSuch, "no_such_router", "no router " + where() + " can be reached",
                    "`timsctl router list` shows the routers of the fleet");
    // Late answers to earlier requests are ignored.
    if (message->header.type != tims::type::kAdminReply) continue;
    json::object answer = parse_answer(*message, where());
    throw_error(answer);
    const auto age = tims::os::now() - asked;
    answer["age_ms"] = std::chrono::duration_cast<std::chrono::milliseconds>(age).count();
    return answer;
  }
  throw Failure(Exit::kTimeout, "timeout", where() + " did not answer the admin request in time",
                "use a longer --timeout; an original RACK router does not support admin requests");
}

std::optional<tims::Address> router_address(const json::object& item) {
  return tims::Address::parse(text_at(item, "address.raw"));
}

json::object walk_fleet(const AdminClient& first) { return FleetWalk(first).run(); }

json::object ask_everywhere(AdminClient& admin, const json::object& question) {
  json::object fleet = walk_fleet(admin);
  json::array rows;
  bool partial = fleet["partial"].as_bool();
  json::value schema;
  for (const json::object& router : objects(items_of(fleet))) {
    if (text_at(router, "state") != "up") continue;
    try {
      json::object answer = admin.at(router_address(router)).ask(question);
      schema = answer["schema"];
      for (json::value& item : item_array(answer)) {
        item.as_object()["at"] = router.at("name");
        rows.push_back(std::move(item));
      }
    } catch (const Failure& failure) {
      if (failure.exit != Exit::kTimeout && failure.exit != Exit::kNoSuch) throw;
      partial = true;
    }
  }
  return {{"schema", schema}, {"partial", partial}, {"items", std::move(rows)}};
}

tims::Address find_router(const AdminClient& first, std::string_view name) {
  const tims::AddressWidths widths = first.widths();
  if (const auto address = parse_address(name, widths);
      address && address->fields(widths).class_id == kRouterClass)
    return *address;
  json::object fleet = walk_fleet(first);
  std::string known;
  for (const json::object& item : objects(items_of(fleet))) {
    const std::string its_name = text_at(item, "name");
    if (its_name == name) return *router_address(item);
    known.append(known.empty() ? "" : ", ").append(its_name);
  }
  throw Failure(Exit::kNoSuch, "no_such_router",
                "no router of the fleet is called \"" + std::string(name) + "\"",
                "known: " + known);
}

}  // namespace timsctl

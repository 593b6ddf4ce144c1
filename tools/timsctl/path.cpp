// timsctl ping, explain and trace: whether a message arrives, its path, and how long it takes.

#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "tools/cli/admin_client.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/message.h"
#include "tools/timsctl/message_path.h"

namespace timsctl {

namespace {

struct Conclusion {
  bool arrives = false;
  std::string cause;   // one sentence
  std::string remedy;  // a command, or what to do
};

class Explainer {
 public:
  Explainer(Context& context, AdminClient admin, tims::Address src, tims::Address dst)
      : context_(context), admin_(admin), src_(src), dst_(dst) {}

  Exit run() {
    const MessageKind kind = MessageKind::of(context_.options, dst_, admin_.widths());
    const std::optional<Step> source = find_source();
    Conclusion conclusion;
    Path path;
    if (!source) {
      conclusion = {false, fmt::format("the sender {} is not registered", name_of(src_)),
                    "start the sending component, then ask again"};
    } else {
      path = find_path(admin_.at(source->router), src_, dst_, kind);
      conclusion = conclude(path);
    }
    print(path, conclusion);
    return conclusion.arrives ? Exit::kDone : Exit::kNo;
  }

 private:
  std::string name_of(tims::Address address) { return address.to_string(admin_.widths()); }

  // Where the sender is registered; a message to it may be routed elsewhere.
  [[nodiscard]] std::optional<Step> find_source() {
    const Path path = find_path(admin_, {}, src_, {.type = tims::type::kGetStatus});
    if (path.reached) return path.steps.back();
    return find_owner(admin_, src_);
  }

  [[nodiscard]] Conclusion conclude(const Path& path) {
    if (path.failure)
      return {false, *path.failure, "`timsctl router list` shows which routers answer"};
    const Step& last = path.steps.back();
    if (text_at(last.answer, "verdict") == "denied")
      return {false,
              base::printable(fmt::format("the policy of {} does not permit it: {}", last.name,
                                          text_at(last.answer, "reason"))),
              fmt::format("`timsctl -r {} acl show` lists its rules", last.name)};
    if (path.reached) return at_mailbox(last);
    if (const auto broken = broken_link(admin_, path, dst_))
      return {false, broken->cause, broken->remedy};
    if (text_at(last.answer, "outcome") == "would_return")
      return {false,
              fmt::format("{} knows {} only behind the router it would come from: that router has "
                          "withdrawn it",
                          last.name, name_of(dst_)),
              fmt::format("`timsctl route watch '{}'` there", name_of(dst_))};
    if (const auto owner = find_owner(admin_, dst_))
      return {
          false,
          fmt::format("{} is registered at {}, to which there is no route: {} discards the message",
                      name_of(dst_), owner->name, last.name),
          fmt::format("`timsctl -r {} route add '{}' --via ...` over a link that leads there",
                      last.name, name_of(dst_))};
    std::string cause = fmt::format(
        "no router of the fleet has {} registered; {} discards the "
        "message",
        name_of(dst_), last.name);
    const std::string away = routers_away();
    if (!away.empty())
      return {false, cause + "; it may be behind " + away,
              "restore that router: is its host up, and its network?"};
    return {false, cause,
            "start the component; `timsctl route show -a` lists all registered addresses"};
  }

  // Programs of the original RACK, connected by TCP, have no name.
  static std::string owner_of(const json::object& answer) {
    std::string name = text_at(answer, "owner.name");
    if (!name.empty()) return name;
    const std::string peer = text_at(answer, "owner.peer");
    return peer.empty() ? "a client without a name" : "the client at " + peer;
  }

  // The owner may not read its messages.
  [[nodiscard]] Conclusion at_mailbox(const Step& last) {
    const json::object answer =
        admin_.at(last.router).ask({{"ask", "mailboxes"}, {"match", dst_.to_hex()}});
    for (const json::object& box : objects(items_of(answer))) {
      const double slots = number_or_zero(box, "slots");
      if (slots > 0 && number_or_zero(box, "waiting") >= slots)
        return {false,
                fmt::format("the mailbox {} is full: its owner {} does not read its messages",
                            name_of(dst_), owner_of(box)),
                fmt::format("`timsctl -r {} mbx show '{}'`", last.name, name_of(dst_))};
    }
    return {true, fmt::format("it arrives: {} delivers it to {}", last.name, owner_of(last.answer)),
            ""};
  }

  // Routers of the fleet that are no longer reachable.
  [[nodiscard]] std::string routers_away() {
    const json::object fleet = walk_fleet(admin_);
    std::string names;
    for (const json::object& router : objects(items_of(fleet))) {
      if (text_at(router, "state") == "up") continue;
      names += fmt::format("{}{} ({} since {})", names.empty() ? "" : ", ", text_at(router, "name"),
                           text_at(router, "state"),
                           base::human_duration(number_or_zero(router, "since_s")));
    }
    return names;
  }

  void print(const Path& path, const Conclusion& conclusion) {
    if (context_.out.json()) {
      json::array items;
      for (const Step& step : path.steps) items.push_back(step.answer);
      context_.out.write(json::object{{"schema", "tims/explain/1"},
                                      {"arrives", conclusion.arrives},
                                      {"cause", conclusion.cause},
                                      {"remedy", conclusion.remedy},
                                      {"items", std::move(items)}});
      return;
    }
    int number = 0;
    for (const Step& step : path.steps)
      context_.out.write(fmt::format("{:>2} {:<16} {}\n", ++number, step.name,
                                     base::printable(text_at(step.answer, "reason"))));
    const Tone tone = conclusion.arrives ? Tone::kGood : Tone::kBad;
    context_.out.write(paint(conclusion.cause, tone, context_.out.look().colour) +
                       (conclusion.remedy.empty() ? "" : "; " + conclusion.remedy) + "\n");
  }

  Context& context_;
  AdminClient admin_;
  tims::Address src_;
  tims::Address dst_;
};

constexpr Column kHops[] = {
    {"HOP", "hop"},
    {"ROUTER", "router"},
    {"FROM", "from.name"},
    {"TO", "to.name"},
    {"WAITED", "waited_s", Cell::kDuration},
    {"DENIED", "denied"},
    {"TIME", "time"},
};

// The trace record in the message, if it contains one.
std::optional<json::object> record_of(const Message& message) {
  if (message.header.type != tims::type::kHopRecord) return std::nullopt;
  return json_of(message);
}

}  // namespace

// --- timsctl explain: why a message arrives or not. Follows the path of the message and asks each
// router what it would do with it.

Exit explain(Context& context) {
  const auto& arguments = context.options.arguments;
  (void)need_addresses(arguments, kAnyWidths);
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  const tims::AddressWidths widths = admin.widths();
  return Explainer(context, admin, need_address(arguments[0], widths),
                   need_address(arguments[1], widths))
      .run();
}

// --- timsctl trace: a message about which every router on its path sends a record.

Exit trace(Context& context) {
  if (std::holds_alternative<TcpHost>(context.host))
    throw usage_error("messages over TCP are not traced", "-H unix:PATH on that host");
  (void)need_address(context.options.arguments.front(), kAnyWidths);
  const auto connection = context.connect();
  const tims::AddressWidths widths = connection->widths();
  const tims::Address target = need_address(context.options.arguments.front(), widths);
  const std::int8_t type = type_to_assume(context.options, target, widths);
  const std::string name = target.to_string(connection->widths());
  const tims::Time sent = tims::os::now();
  auto result = connection->send({.dest = target,
                                  .type = type,
                                  .priority = context.options.priority,
                                  .seq_nr = connection->next_seq_nr(),
                                  .trace = true},
                                 {});
  if (!result) throw failure_of(result.error(), name);
  json::array hops;
  std::optional<Message> answer;
  std::optional<double> seconds;
  // Records may arrive after the answer.
  tims::Time deadline = tims::os::deadline_after(context.options.timeout);
  while (auto message = receive(*connection, context.signals, deadline)) {
    if (auto record = record_of(*message)) {
      hops.push_back(std::move(*record));
    } else if (message->header.src == target) {
      seconds = base::seconds(tims::os::now() - sent);
      answer = std::move(*message);
      deadline = std::min(deadline, tims::os::deadline_after(std::chrono::milliseconds(100)));
    }
  }
  std::ranges::sort(hops, {},
                    [](const json::value& hop) { return number_or_zero(hop.as_object(), "hop"); });
  const bool reached = answer && answer->header.type != tims::type::kNotAvailable;
  std::string denied;
  for (const json::object& hop : objects(hops))
    if (denied.empty()) denied = text_at(hop, "denied");
  if (context.out.json()) {
    context.out.write(json::object{{"schema", "tims/trace/1"},
                                   {"target", name},
                                   {"reached", reached},
                                   {"rtt_s", seconds ? json::value(*seconds) : json::value()},
                                   {"items", std::move(hops)}});
  } else {
    if (hops.empty())
      context.out.note("there was no router on the path: the component is on this host");
    context.out.write(render_items(hops, kHops, context.out.look()));
    const std::string end =
        !answer ? "no answer"
                : fmt::format("{} after {}",
                              reached          ? type_name(answer->header.type)
                              : denied.empty() ? "no such mailbox"
                                               : "denied by " + base::printable(denied),
                              base::human_duration(*seconds));
    context.out.write(fmt::format("{}: {}\n", name, end));
  }
  if (!answer) return Exit::kTimeout;
  return reached ? Exit::kDone : Exit::kNoSuch;
}

// --- timsctl ping: round trips, with GET_STATUS to a component or the admin ping to a router.

namespace {

using namespace std::chrono_literals;

struct Answer {
  std::string text;  // "enabled"
  bool reached = true;
};
// Sends one request; empty if there was no answer before the deadline.
using Ask = std::function<std::optional<Answer>(std::uint8_t number, tims::Time deadline)>;

struct RoundTrip {
  std::uint64_t number = 0;
  std::optional<double> seconds;  // empty: lost
  std::string answer;
};

struct Statistics {
  double min = 0;
  double mean = 0;
  double max = 0;
  double jitter = 0;  // mean change between consecutive round trips
};

std::optional<Statistics> statistics_of(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  const auto [min, max] = std::ranges::minmax(values);
  Statistics n{.min = min, .max = max};
  for (const double v : values) n.mean += v / static_cast<double>(values.size());
  for (std::size_t i = 1; i < values.size(); ++i)
    n.jitter += std::abs(values[i] - values[i - 1]) / static_cast<double>(values.size() - 1);
  return n;
}

class Pinger {
 public:
  // `absence`: why it does not answer, if that is known.
  Pinger(Context& context, std::string target, Ask ask,
         std::function<std::optional<BrokenLink>()> absence = nullptr)
      : context_(context),
        target_(std::move(target)),
        ask_(std::move(ask)),
        absence_(std::move(absence)) {}

  Exit run() {
    const Options& options = context_.options;
    const std::uint64_t count = options.count.value_or(options.run_for ? UINT64_MAX : 4);
    const tims::Time end = context_.run_end();
    tims::Time next = tims::os::now();
    bool interrupted = false;
    try {
      while (trips_.size() < count && next < end && exit_ == Exit::kDone) {
        context_.signals.sleep_until(next);
        one_trip();
        next = std::max(next + options.interval.value_or(1s), tims::os::now());
      }
    } catch (const Interrupted&) {
      interrupted = true;
    }
    if (absence_ && !trips_.empty() && !trips_.back().seconds) broken_ = absence_();
    context_.out.write(summary_json(), [&] { return summary(); });
    if (interrupted) throw Interrupted();
    if (exit_ != Exit::kDone) return exit_;
    return seconds_.size() == trips_.size() ? Exit::kDone : Exit::kTimeout;
  }

 private:
  void one_trip() {
    RoundTrip trip{.number = trips_.size() + 1, .seconds = {}, .answer = "no answer"};
    const tims::Time asked = tims::os::now();
    const auto answer = ask_(static_cast<std::uint8_t>(trip.number),
                             tims::os::deadline_after(context_.options.timeout));
    if (answer) trip.answer = answer->text;
    if (answer && !answer->reached) exit_ = Exit::kNoSuch;
    if (answer && answer->reached) {
      trip.seconds = base::seconds(tims::os::now() - asked);
      seconds_.push_back(*trip.seconds);
    }
    trips_.push_back(trip);
    print(trip);
  }

  void print(const RoundTrip& trip) {
    if (context_.out.json() || context_.options.quiet) return;
    const std::string time = trip.seconds ? base::human_duration(*trip.seconds) : "-";
    const Tone tone = trip.seconds ? Tone::kPlain : Tone::kBad;
    context_.out.write(fmt::format("{}: {} {} {}\n", target_, trip.number, time,
                                   paint(trip.answer, tone, context_.out.look().colour)));
  }

  [[nodiscard]] std::string summary() const {
    const std::size_t lost = trips_.size() - seconds_.size();
    const double loss =
        trips_.empty() ? 0 : 100.0 * static_cast<double>(lost) / static_cast<double>(trips_.size());
    std::string text = fmt::format("{}: {} sent, {} answered, {:.0f}% lost\n", target_,
                                   trips_.size(), seconds_.size(), loss);
    if (const auto n = statistics_of(seconds_))
      text += fmt::format("round trip min/avg/max/jitter {} / {} / {} / {}\n",
                          base::human_duration(n->min), base::human_duration(n->mean),
                          base::human_duration(n->max), base::human_duration(n->jitter));
    if (exit_ == Exit::kNoSuch)
      text += fmt::format("{}: this address is not registered\n", target_);
    if (broken_) text += fmt::format("{}; {}\n", broken_->cause, broken_->remedy);
    return text;
  }

  [[nodiscard]] json::object summary_json() const {
    json::array items;
    for (const RoundTrip& trip : trips_)
      items.push_back(
          json::object{{"number", trip.number},
                       {"rtt_s", trip.seconds ? json::value(*trip.seconds) : json::value()},
                       {"answer", trip.answer}});
    json::object out{{"schema", "tims/ping_summary/1"},
                     {"target", target_},
                     {"time", base::rfc3339(tims::os::wall_now())},
                     {"sent", trips_.size()},
                     {"answered", seconds_.size()},
                     {"reached", !seconds_.empty()},
                     {"partial", seconds_.size() != trips_.size()}};
    const auto n = statistics_of(seconds_);
    const auto put = [&](const char* name, double Statistics::*field) {
      out[name] = n ? json::value((*n).*field) : json::value();
    };
    put("rtt_min_s", &Statistics::min);
    put("rtt_avg_s", &Statistics::mean);
    put("rtt_max_s", &Statistics::max);
    put("jitter_s", &Statistics::jitter);
    if (broken_) out["cause"] = broken_->cause;
    out["items"] = std::move(items);
    return out;
  }

  Context& context_;
  std::string target_;
  Ask ask_;
  std::function<std::optional<BrokenLink>()> absence_;
  std::optional<BrokenLink> broken_;
  std::vector<RoundTrip> trips_;
  std::vector<double> seconds_;  // of the answered requests
  Exit exit_ = Exit::kDone;
};

std::string answer_text(const tims::Header& header) {
  if (header.type == tims::type::kNotAvailable) return "no such mailbox";
  const std::string name = type_name(header.type);
  return name.empty() ? fmt::format("type {}", header.type) : name;
}

Exit ping_component(Context& context, Connection& connection, tims::Address target) {
  const std::string name = target.to_string(connection.widths());
  const auto ask = [&](std::uint8_t number, tims::Time deadline) -> std::optional<Answer> {
    auto sent = connection.send({.dest = target,
                                 .type = tims::type::kGetStatus,
                                 .priority = context.options.priority,
                                 .seq_nr = number},
                                {});
    if (!sent && sent.error().code() == tims::Errc::kNoMailbox)
      return Answer{"no such mailbox", false};
    if (!sent) throw failure_of(sent.error(), name);
    while (auto message = receive(connection, context.signals, deadline)) {
      // Late answers have another sequence number.
      if (message->header.src != target || message->header.seq_nr != number) continue;
      return Answer{answer_text(message->header),
                    message->header.type != tims::type::kNotAvailable};
    }
    return std::nullopt;
  };
  return Pinger(context, name, ask, [&] { return broken_link_to(context, connection, target); })
      .run();
}

Exit ping_router(Context& context, Connection& connection, AdminClient admin) {
  json::object question{{"ask", "ping"}};
  if (context.options.size_bytes > 0) {
    constexpr std::uint32_t kPadMax = 60'000;
    if (context.options.size_bytes > kPadMax)
      throw usage_error(fmt::format("--size: a request has at most {} bytes", kPadMax));
    question["pad"] = std::string(context.options.size_bytes, '.');
  }
  const auto ask = [&](std::uint8_t, tims::Time) -> std::optional<Answer> {
    try {
      return Answer{text_at(admin.ask(question), "address.name")};
    } catch (const Failure& failure) {
      if (failure.exit != Exit::kTimeout) throw;
      return std::nullopt;
    }
  };
  const std::string name =
      admin.router() ? admin.router()->to_string(admin.widths()) : connection.where();
  return Pinger(context, "router " + name, ask).run();
}

// Every router on the path, the nearest first.
void ping_hops(Context& context, Connection& connection, tims::Address target) {
  const AdminClient admin = context.admin(connection);
  const Path path =
      find_path(admin, connection.address(), target, {.type = tims::type::kGetStatus});
  for (const Step& step : path.steps)
    if (step.router && *step.router != target)
      (void)ping_router(context, connection, admin.at(step.router));
}

}  // namespace

Exit ping(Context& context) {
  const std::string& target = context.options.arguments.front();
  const bool its_router = target == "router";
  if (!its_router) (void)need_address(target, kAnyWidths);
  const auto connection = context.connect();
  if (its_router) return ping_router(context, *connection, context.admin(*connection));
  const tims::Address address = need_address(target, connection->widths());
  if (context.options.hops) ping_hops(context, *connection, address);
  const auto fields = address.fields(connection->widths());
  if (fields.class_id == tims::class_id::kTims && fields.local == 0)
    return ping_router(context, *connection,
                       {*connection, context.signals, context.options.timeout, address});
  if (context.options.size_bytes > 0)
    throw usage_error("--size is for `ping router`: GET_STATUS has no body");
  return ping_component(context, *connection, address);
}

}  // namespace timsctl

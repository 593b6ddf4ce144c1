// timsctl ping: round trips. A component is asked for its status, a router by the admin ping.
#include <algorithm>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "base/wall_time.h"
#include "os/clock.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/explain.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

namespace {

using namespace std::chrono_literals;

struct Answer {
  std::string text;  // "enabled"
  bool reached = true;
};
// One question; nothing when no answer came before the deadline.
using Ask = std::function<std::optional<Answer>(std::uint8_t number, tims::Time deadline)>;

struct Trip {
  std::uint64_t number = 0;
  std::optional<double> seconds;  // nothing: lost
  std::string answer;
};

class Pinger {
 public:
  Pinger(Context& context, std::string target, Ask ask)
      : context_(context), target_(std::move(target)), ask_(std::move(ask)) {}

  Exit run();

 private:
  void one_trip();
  void tell(const Trip& trip);
  void summary() const;
  [[nodiscard]] json::object summary_json() const;

  Context& context_;
  std::string target_;
  Ask ask_;
  std::vector<Trip> trips_;
  std::vector<double> seconds_;  // of the answered ones
  Exit exit_ = Exit::kDone;
};

Exit Pinger::run() {
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
  if (context_.out.json())
    context_.out.write(summary_json());
  else
    summary();
  if (interrupted) throw Interrupted();
  if (exit_ != Exit::kDone) return exit_;
  return seconds_.size() == trips_.size() ? Exit::kDone : Exit::kTimeout;
}

void Pinger::one_trip() {
  Trip trip{.number = trips_.size() + 1, .seconds = {}, .answer = "no answer"};
  const tims::Time asked = tims::os::now();
  const auto answer = ask_(static_cast<std::uint8_t>(trip.number),
                           tims::os::deadline_after(context_.options.timeout));
  if (answer) trip.answer = answer->text;
  if (answer && !answer->reached) exit_ = Exit::kNoSuch;
  if (answer && answer->reached) {
    trip.seconds = std::chrono::duration<double>(tims::os::now() - asked).count();
    seconds_.push_back(*trip.seconds);
  }
  trips_.push_back(trip);
  tell(trip);
}

void Pinger::tell(const Trip& trip) {
  if (context_.out.json() || context_.options.quiet) return;
  const std::string time = trip.seconds ? base::human_duration(*trip.seconds) : "-";
  const Tone tone = trip.seconds ? Tone::kPlain : Tone::kBad;
  context_.out.write(fmt::format("{}: {} {} {}\n", target_, trip.number, time,
                                 paint(trip.answer, tone, context_.out.look().colour)));
}

struct Numbers {
  double min = 0;
  double mean = 0;
  double max = 0;
  double jitter = 0;  // mean change from one to the next
};

std::optional<Numbers> numbers_of(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  const auto [min, max] = std::ranges::minmax(values);
  Numbers n{.min = min, .max = max};
  for (const double v : values) n.mean += v / static_cast<double>(values.size());
  for (std::size_t i = 1; i < values.size(); ++i)
    n.jitter += std::abs(values[i] - values[i - 1]) / static_cast<double>(values.size() - 1);
  return n;
}

void Pinger::summary() const {
  const std::size_t lost = trips_.size() - seconds_.size();
  const double loss =
      trips_.empty() ? 0 : 100.0 * static_cast<double>(lost) / static_cast<double>(trips_.size());
  std::string text = fmt::format("{}: {} sent, {} answered, {:.0f}% lost\n", target_, trips_.size(),
                                 seconds_.size(), loss);
  if (const auto n = numbers_of(seconds_))
    text += fmt::format("round trip min/avg/max/jitter {} / {} / {} / {}\n",
                        base::human_duration(n->min), base::human_duration(n->mean),
                        base::human_duration(n->max), base::human_duration(n->jitter));
  if (exit_ == Exit::kNoSuch)
    text += fmt::format("{}: nobody has registered this address\n", target_);
  context_.out.write(text);
}

json::object Pinger::summary_json() const {
  json::array items;
  for (const Trip& trip : trips_)
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
  const auto n = numbers_of(seconds_);
  const auto put = [&](const char* name, double Numbers::*field) {
    out[name] = n ? json::value((*n).*field) : json::value();
  };
  put("rtt_min_s", &Numbers::min);
  put("rtt_avg_s", &Numbers::mean);
  put("rtt_max_s", &Numbers::max);
  put("jitter_s", &Numbers::jitter);
  out["items"] = std::move(items);
  return out;
}

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
      // Late answers carry another number.
      if (message->header.src != target || message->header.seq_nr != number) continue;
      return Answer{answer_text(message->header),
                    message->header.type != tims::type::kNotAvailable};
    }
    return std::nullopt;
  };
  return Pinger(context, name, ask).run();
}

Exit ping_router(Context& context, Connection& connection, AdminClient admin) {
  json::object question{{"ask", "ping"}};
  if (context.options.size_bytes > 0) {
    constexpr std::uint32_t kPadMax = 60'000;
    if (context.options.size_bytes > kPadMax)
      throw usage_error(fmt::format("--size: a question has at most {} bytes", kPadMax));
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

// Every router on the way, the nearest first.
void ping_hops(Context& context, Connection& connection, tims::Address target) {
  const AdminClient admin = context.admin(connection);
  const Path path = find_path(admin, connection.address(), target, tims::type::kGetStatus);
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

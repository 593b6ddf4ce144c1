// timsctl msg hz and bw: several streams side by side.
#include <fmt/format.h>

#include "os/clock.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/humanize.h"
#include "tools/timsctl/message_text.h"
#include "tools/timsctl/rate_meter.h"
#include "tools/timsctl/subscription.h"
#include "tools/timsctl/values.h"

namespace timsctl {

namespace {

using namespace std::chrono_literals;

constexpr Column kHz[] = {
    {"ADDRESS", "address.name"},
    {"HZ", "rate_hz", As::kRate},
    {"MIN", "interval_min_s", As::kDuration},
    {"MAX", "interval_max_s", As::kDuration},
    {"STD", "interval_std_s", As::kDuration},
    {"JITTER", "jitter_s", As::kDuration},
    {"MESSAGES", "messages_total", As::kCount},
    {"LOST", "lost", As::kCount, false, true},
    {"BYTES/S", "bytes_per_s", As::kBytes, true},
    {"SILENT", "silent_s", As::kDuration, true},
    {"STATE", "state"},
};
constexpr Column kBw[] = {
    {"ADDRESS", "address.name"},
    {"BYTES/S", "bytes_per_s", As::kBytes},
    {"MIN", "body_min_bytes", As::kBytes},
    {"MEAN", "body_mean_bytes", As::kBytes},
    {"MAX", "body_max_bytes", As::kBytes},
    {"HZ", "rate_hz", As::kRate},
    {"MESSAGES", "messages_total", As::kCount},
    {"LOST", "lost", As::kCount, false, true},
    {"STATE", "state"},
};

json::value or_null(const std::optional<double>& value) {
  return value ? json::value(*value) : json::value();
}

json::object item_json(const Subscription& subscription, const RateReport& report,
                       const tims::AddressWidths& widths) {
  json::object item{{"address", address_json(subscription.component(), widths)},
                    {"state", subscription.state_name()},
                    {"messages", report.messages},
                    {"messages_total", report.messages_total},
                    {"bytes_per_s", report.bytes_per_s},
                    {"body_min_bytes", report.body_min_bytes},
                    {"body_mean_bytes", report.body_mean_bytes},
                    {"body_max_bytes", report.body_max_bytes},
                    {"lost", report.lost ? json::value(*report.lost) : json::value()},
                    {"silent_s", or_null(report.silent_s)}};
  if (const auto granted = subscription.granted_ms()) item["period_s"] = *granted / 1000.0;
  const auto& intervals = report.intervals;
  const auto put = [&](const char* name, double RateReport::Intervals::*field) {
    item[name] = intervals ? json::value((*intervals).*field) : json::value();
  };
  put("rate_hz", &RateReport::Intervals::rate_hz);
  put("interval_min_s", &RateReport::Intervals::min_s);
  put("interval_max_s", &RateReport::Intervals::max_s);
  put("interval_std_s", &RateReport::Intervals::std_s);
  put("jitter_s", &RateReport::Intervals::jitter_s);
  return item;
}

class RateWatch {
 public:
  RateWatch(Context& context, Connection& connection, const std::vector<tims::Address>& components,
            std::span<const Column> columns)
      : context_(context),
        widths_(connection.widths()),
        columns_(columns),
        subscriptions_(connection, components, period_ms(context.options)),
        meters_(components.size(), RateMeter(tims::os::now())) {}

  Exit run();

 private:
  static std::uint32_t period_ms(const Options& options) {
    return static_cast<std::uint32_t>(
        std::chrono::duration_cast<std::chrono::milliseconds>(options.period).count());
  }
  void listen_until(tims::Time deadline);
  void report();
  void check_reachable() const;
  [[nodiscard]] Exit verdict() const;

  Context& context_;
  tims::AddressWidths widths_;
  std::span<const Column> columns_;
  Subscriptions subscriptions_;
  std::vector<RateMeter> meters_;
  std::vector<std::uint64_t> totals_;
  std::uint64_t missed_ = 0;
};

void RateWatch::listen_until(tims::Time deadline) {
  while (const auto data = subscriptions_.next(context_.signals, deadline))
    meters_[data->index].on_message(data->at, static_cast<std::uint32_t>(data->message.body.size()),
                                    data->message.header.seq_nr);
}

// A person waiting for numbers of an address nobody has would wait for ever.
void RateWatch::check_reachable() const {
  const auto& all = subscriptions_.all();
  for (const Subscription& s : all)
    if (s.state() != Subscription::State::kNoMailbox) return;
  throw Failure(Exit::kNoSuch, "no_such_mailbox",
                all.front().component().to_string(widths_) + ": nobody has registered this address",
                "`timsctl mbx list` shows all");
}

void RateWatch::report() {
  json::array items;
  totals_.clear();
  const tims::Time now = tims::os::now();
  for (std::size_t i = 0; i < meters_.size(); ++i) {
    const RateReport numbers = meters_[i].report(now);
    totals_.push_back(numbers.messages_total);
    items.push_back(item_json(subscriptions_.all()[i], numbers, widths_));
  }
  const Look& look = context_.out.look();
  if (look.format == Format::kJson)
    return context_.out.write(json::object{
        {"schema", "tims/rate/1"}, {"time", rfc3339(wall_now())}, {"items", std::move(items)}});
  const std::span<const json::value> rows(items.data(), items.size());
  if (const std::uint64_t missed = subscriptions_.missed(); missed > missed_) {
    context_.out.note(
        fmt::format("{} messages came faster than timsctl takes them, or were larger "
                    "than --body-max",
                    missed - missed_));
    missed_ = missed;
  }
  const bool once = context_.options.count == 1;
  if (context_.out.terminal() && !once)
    return context_.out.redraw(render_items(rows, columns_, look));
  context_.out.write(render_items(rows, columns_, look));
}

Exit RateWatch::verdict() const {
  bool missing = false;
  for (const Subscription& s : subscriptions_.all())
    missing = missing || s.state() == Subscription::State::kNoMailbox;
  if (missing) return Exit::kNoSuch;
  const bool silent = std::ranges::find(totals_, 0U) != totals_.end();
  return silent ? Exit::kTimeout : Exit::kDone;
}

Exit RateWatch::run() {
  const Options& options = context_.options;
  const std::uint64_t count = options.count.value_or(UINT64_MAX);
  const tims::Time end =
      options.run_for ? tims::os::deadline_after(*options.run_for) : tims::kNever;
  const tims::Duration interval = options.interval.value_or(1s);
  if (context_.out.terminal() && !context_.out.json() && count > 1) context_.out.write("\033[2J");
  tims::Time next = tims::os::now();
  for (std::uint64_t i = 0; i < count && next < end; ++i) {
    next = std::min(next + interval, end);
    listen_until(next);
    if (i == 0) check_reachable();
    report();
  }
  return verdict();
}

Exit measure(Context& context, std::span<const Column> columns) {
  const Options& options = context.options;
  (void)need_addresses(options.arguments, kAnyWidths);
  const auto connection =
      context.connect({.address = {}, .slots = 256, .body_max = options.body_max_bytes});
  const auto components = need_addresses(options.arguments, connection->widths());
  return RateWatch(context, *connection, components, columns).run();
}

}  // namespace

Exit msg_hz(Context& context) { return measure(context, kHz); }
Exit msg_bw(Context& context) { return measure(context, kBw); }

}  // namespace timsctl

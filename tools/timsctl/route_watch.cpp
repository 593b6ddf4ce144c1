// timsctl route watch: registrations as they come and go. The question waits at the router until
// something happens.
#include <fmt/format.h>

#include "os/clock.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/humanize.h"
#include "tools/timsctl/values.h"

namespace timsctl {

namespace {

using namespace std::chrono_literals;

class RouteWatch {
 public:
  explicit RouteWatch(Context& context)
      : context_(context),
        left_(context.options.count.value_or(UINT64_MAX)),
        end_(context.options.run_for ? tims::os::deadline_after(*context.options.run_for)
                                     : tims::kNever) {
    if (!context.options.arguments.empty())
      (void)need_pattern(context.options.arguments.front(), kAnyWidths);
  }

  Exit run() {
    open();
    context_.out.note(fmt::format("watching {}, Ctrl-C ends", connection_->where()));
    while (left_ > 0 && tims::os::now() < end_) {
      try {
        step();
      } catch (const Failure& failure) {
        if (failure.exit != Exit::kNoRouter && failure.exit != Exit::kTimeout) throw;
        reopen(failure);
      }
    }
    return Exit::kDone;
  }

 private:
  void open() {
    connection_ = context_.connect();
    if (since_) return;
    AdminClient admin = context_.admin(*connection_);
    if (!context_.options.arguments.empty())
      pattern_ = need_pattern(context_.options.arguments.front(), admin.widths());
    const json::object answer = admin.ask({{"ask", "events"}});
    remember(answer);
  }

  void remember(const json::object& answer) {
    since_ = static_cast<std::int64_t>(number_or_zero(answer, "last"));
    epoch_ = text_at(answer, "epoch");
  }

  void reopen(const Failure& failure) {
    context_.out.note(failure.message + ", trying again");
    connection_.reset();
    while (!connection_ && tims::os::now() < end_) {
      context_.signals.sleep_until(std::min(tims::os::deadline_after(500ms), end_));
      try {
        open();
      } catch (const Failure& again) {
        if (again.exit != Exit::kNoRouter && again.exit != Exit::kTimeout) throw;
        connection_.reset();
      }
    }
  }

  void step() {
    const auto wait = std::min<tims::Duration>(10s, end_ - tims::os::now());
    const auto wait_ms = std::max<std::int64_t>(
        0, std::chrono::duration_cast<std::chrono::milliseconds>(wait).count());
    AdminClient admin = context_.admin(*connection_);
    const json::object answer = admin.ask(
        {{"ask", "events"}, {"since", *since_}, {"epoch", epoch_}, {"wait_ms", wait_ms}}, wait);
    if (text_at(answer, "epoch") != epoch_) context_.out.note("the router was started anew");
    if (const double lost = number_or_zero(answer, "lost"); lost > 0)
      context_.out.note(fmt::format("{:.0f} events came faster than they could be told", lost));
    for (const json::value& item : items_of(answer)) tell(item.as_object(), answer);
    remember(answer);
  }

  [[nodiscard]] bool wanted(const json::object& event) const {
    const std::string kind = text_at(event, "kind");
    if (kind != "registered" && kind != "withdrawn" && kind != "address_refused" &&
        kind != "delete_refused")
      return false;
    const auto address = parse_address(text_at(event, "address.raw"));
    return pattern_.matches(address.value_or(tims::Address()));
  }

  void tell(const json::object& event, const json::object& answer) {
    if (left_ == 0 || !wanted(event)) return;
    --left_;
    const Look& look = context_.out.look();
    if (look.format == Format::kJson) {
      json::object line{{"schema", "tims/event/1"}, {"router", text_at(answer, "router")}};
      for (const auto& [key, value] : event) line[key] = value;
      return context_.out.write(line);
    }
    const std::string kind = text_at(event, "kind");
    const Tone tone = kind == "registered"  ? Tone::kGood
                      : kind == "withdrawn" ? Tone::kWarning
                                            : Tone::kBad;
    context_.out.write(fmt::format("{}  {}  {}\n", local_time(text_at(event, "time"), look.utc),
                                   paint(fmt::format("{:<15}", kind), tone, look.colour),
                                   printable(text_at(event, "text"))));
  }

  Context& context_;
  std::uint64_t left_;
  tims::Time end_;
  tims::AddressPattern pattern_;
  std::unique_ptr<Connection> connection_;
  std::optional<std::int64_t> since_;
  std::string epoch_;  // of the router that counted up to since_
};

}  // namespace

Exit route_watch(Context& context) { return RouteWatch(context).run(); }

}  // namespace timsctl

// timsctl msg echo: messages as they come.
#include <fmt/format.h>
#include <unistd.h>

#include "os/clock.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/message_fields.h"
#include "tools/timsctl/message_text.h"
#include "tools/timsctl/missed.h"
#include "tools/timsctl/subscription.h"
#include "tools/timsctl/values.h"

namespace timsctl {

namespace {

// Of a body, and of a sequence in it; all with -o wide, or into a pipe.
constexpr std::size_t kTerminalBytes = 256;
constexpr std::size_t kTerminalElements = 3;

class Echo {
 public:
  Echo(Context& context, Connection& connection)
      : context_(context),
        connection_(connection),
        left_(context.options.count.value_or(UINT64_MAX)),
        end_(context.options.run_for ? tims::os::deadline_after(*context.options.run_for)
                                     : tims::kNever),
        filter_(context.options.filter),
        style_{
            .widths = connection.widths(),
            .utc = context.options.utc,
            .si = context.options.si,
            .fields = context.options.fields,
            .header = !context.options.listen.empty() || context.options.format == Format::kWide} {}

  Exit subscribe();
  Exit listen();

 private:
  void tell(const Message& message);
  void note_changes(const Subscriptions& subscriptions);
  [[nodiscard]] std::string name_of(tims::Address address) const {
    return address.to_string(connection_.widths());
  }
  [[nodiscard]] Exit end() const {
    const bool complete = !context_.options.count || left_ == 0;
    return complete && (told_ > 0 || !context_.options.run_for) ? Exit::kDone : Exit::kTimeout;
  }

  Context& context_;
  Connection& connection_;
  std::uint64_t left_;
  std::uint64_t told_ = 0;
  tims::Time end_;
  std::vector<Subscription::State> states_;
  Missed missed_{"messages"};
  FieldFilter filter_;
  FieldStyle style_;
  CsvLines csv_;
};

void Echo::tell(const Message& message) {
  const WallTime now = wall_now();
  const Format format = context_.out.look().format;
  const bool lines = format == Format::kTable || format == Format::kWide;
  if (!lines || !filter_.empty()) {
    const json::object described = described_json(message, now, style_);
    if (!filter_.passes(described)) return;
    if (format == Format::kJson) context_.out.write(described);
    if (format == Format::kCsv) context_.out.write(csv_.add(described));
  }
  --left_;
  ++told_;
  if (!lines) return;
  const bool shorten = context_.out.terminal() && format != Format::kWide;
  if (context_.options.raw)
    return context_.out.write(dump(message, now,
                                   {.widths = style_.widths,
                                    .utc = style_.utc,
                                    .bytes_max = shorten ? kTerminalBytes : SIZE_MAX}));
  FieldStyle style = style_;
  if (shorten) style.elements_max = kTerminalElements;
  context_.out.write(describe(message, now, style));
}

// What does not come says why. Alone and without -n or --for, an address that nobody has is an
// error at once; later it may come back.
void Echo::note_changes(const Subscriptions& subscriptions) {
  const auto& all = subscriptions.all();
  states_.resize(all.size(), Subscription::State::kAsking);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto state = all[i].state();
    if (state == states_[i]) continue;
    const bool first = states_[i] == Subscription::State::kAsking;
    states_[i] = state;
    const std::string who = name_of(all[i].component());
    if (state == Subscription::State::kNoMailbox && first && all.size() == 1)
      throw Failure(Exit::kNoSuch, "no_such_mailbox", who + ": nobody has registered this address",
                    "`timsctl mbx list` shows all");
    if (state == Subscription::State::kOff && first && all.size() == 1)
      throw Failure(Exit::kNo, "component_off",
                    who + " gives no data: it answers ERROR, as a component does that is off",
                    fmt::format("timsctl msg pub {} on", all[i].component().to_hex()));
    if (state == Subscription::State::kNoMailbox) context_.out.note(who + " is not there, waiting");
    if (state == Subscription::State::kOff) context_.out.note(who + " is off, waiting");
    if (state == Subscription::State::kRunning)
      context_.out.detail(
          fmt::format("{} sends every {} ms", who, all[i].granted_ms().value_or(0)));
  }
}

Exit Echo::subscribe() {
  const auto components = need_addresses(context_.options.arguments, connection_.widths());
  for (const tims::Address component : components) {
    const auto* data =
        rack::find_message(component.fields(style_.widths).class_id, tims::type::kData);
    if (data != nullptr && data->body != nullptr) filter_.check(*data->body);
  }
  const auto period =
      std::chrono::duration_cast<std::chrono::milliseconds>(context_.options.period);
  Subscriptions subscriptions(connection_, components, static_cast<std::uint32_t>(period.count()));
  const tims::Time patience = tims::os::deadline_after(context_.options.timeout);
  while (left_ > 0 && tims::os::now() < end_) {
    const auto tick = tims::os::deadline_after(std::chrono::milliseconds(200));
    const auto data = subscriptions.next(context_.signals, std::min(end_, tick));
    note_changes(subscriptions);
    missed_.note(connection_, context_.out);
    if (data) tell(data->message);
    const bool asking = subscriptions.all().front().state() == Subscription::State::kAsking;
    if (components.size() == 1 && asking && tims::os::now() > patience)
      throw Failure(Exit::kTimeout, "timeout",
                    name_of(components.front()) + " does not answer GET_CONT_DATA",
                    "is its owner busy? `timsctl mbx show ADDR` shows what waits");
  }
  return end();
}

Exit Echo::listen() {
  context_.out.note(name_of(connection_.address()) + " is registered, Ctrl-C ends");
  while (left_ > 0) {
    const auto message = receive(connection_, context_.signals, end_);
    if (!message) break;
    tell(*message);
    missed_.note(connection_, context_.out);
    // Who sends a command waits for an answer; this one is of nobody who can carry it out.
    if (message->header.type > 0)
      (void)connection_.send({.dest = message->header.src,
                              .type = tims::type::kError,
                              .priority = message->header.priority,
                              .seq_nr = message->header.seq_nr},
                             {});
  }
  return end();
}

}  // namespace

Exit msg_echo(Context& context) {
  const Options& options = context.options;
  const bool listens = !options.listen.empty();
  if (listens != options.arguments.empty())
    throw usage_error("msg echo: either ADDR... or --listen ADDR");
  if (listens) (void)need_address(options.listen, kAnyWidths);
  (void)need_addresses(options.arguments, kAnyWidths);
  (void)FieldFilter(options.filter);
  const auto connection =
      context.connect({.address = options.listen, .body_max = options.body_max_bytes});
  Echo echo(context, *connection);
  return listens ? echo.listen() : echo.subscribe();
}

}  // namespace timsctl

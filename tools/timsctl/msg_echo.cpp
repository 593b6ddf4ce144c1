// timsctl msg echo: messages as they come.
#include <fmt/format.h>
#include <unistd.h>

#include "os/clock.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/message_text.h"
#include "tools/timsctl/subscription.h"

namespace timsctl {

namespace {

constexpr std::size_t kTerminalBytes = 256;  // of a body; all of it with -o wide, or into a pipe

class Echo {
 public:
  explicit Echo(Context& context)
      : context_(context),
        left_(context.options.count.value_or(UINT64_MAX)),
        end_(context.options.run_for ? tims::os::deadline_after(*context.options.run_for)
                                     : tims::kNever) {}

  Exit subscribe();
  Exit listen();

 private:
  void tell(const Message& message);
  void note_missed(const Connection& connection);
  void note_changes(const Subscriptions& subscriptions);
  [[nodiscard]] Exit end() const {
    const bool complete = !context_.options.count || left_ == 0;
    return complete && (told_ > 0 || !context_.options.run_for) ? Exit::kDone : Exit::kTimeout;
  }

  Context& context_;
  std::uint64_t left_;
  std::uint64_t told_ = 0;
  tims::Time end_;
  std::vector<Subscription::State> states_;
  std::uint64_t missed_ = 0;
};

void Echo::tell(const Message& message) {
  --left_;
  ++told_;
  const WallTime now = wall_now();
  if (context_.out.json()) return context_.out.write(message_json(message, now));
  const bool shorten = context_.out.terminal() && context_.out.look().format != Format::kWide;
  context_.out.write(
      dump(message, now,
           {.utc = context_.options.utc, .bytes_max = shorten ? kTerminalBytes : SIZE_MAX}));
}

// Too many, or too large for the mailbox.
void Echo::note_missed(const Connection& connection) {
  if (connection.missed() == missed_) return;
  context_.out.note(
      fmt::format("{} messages were lost: too fast for this output, or larger than "
                  "--body-max",
                  connection.missed() - missed_));
  missed_ = connection.missed();
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
    const std::string who = all[i].component().to_string();
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
  std::vector<tims::Address> components;
  for (const std::string& text : context_.options.arguments)
    components.push_back(need_address(text));
  const auto connection =
      context_.connect({.address = {}, .body_max = context_.options.body_max_bytes});
  const auto period =
      std::chrono::duration_cast<std::chrono::milliseconds>(context_.options.period);
  Subscriptions subscriptions(*connection, components, static_cast<std::uint32_t>(period.count()));
  const tims::Time patience = tims::os::deadline_after(context_.options.timeout);
  while (left_ > 0 && tims::os::now() < end_) {
    const auto tick = tims::os::deadline_after(std::chrono::milliseconds(200));
    const auto data = subscriptions.next(context_.signals, std::min(end_, tick));
    note_changes(subscriptions);
    note_missed(*connection);
    if (data) tell(data->message);
    const bool asking = subscriptions.all().front().state() == Subscription::State::kAsking;
    if (components.size() == 1 && asking && tims::os::now() > patience)
      throw Failure(Exit::kTimeout, "timeout",
                    components.front().to_string() + " does not answer GET_CONT_DATA",
                    "is its owner busy? `timsctl mbx show ADDR` shows what waits");
  }
  return end();
}

Exit Echo::listen() {
  const tims::Address address = need_address(context_.options.listen);
  const auto connection =
      context_.connect({.address = address, .body_max = context_.options.body_max_bytes});
  context_.out.note(address.to_string() + " is registered, Ctrl-C ends");
  while (left_ > 0) {
    const auto message = receive(*connection, context_.signals, end_);
    if (!message) break;
    tell(*message);
    note_missed(*connection);
    // Who sends a command waits for an answer; this one is of nobody who can carry it out.
    if (message->header.type > 0)
      (void)connection->send({.dest = message->header.src,
                              .type = tims::type::kError,
                              .priority = message->header.priority,
                              .seq_nr = message->header.seq_nr},
                             {});
  }
  return end();
}

}  // namespace

Exit msg_echo(Context& context) {
  const bool has_arguments = !context.options.arguments.empty();
  if (context.options.listen.empty() != has_arguments)
    throw usage_error("msg echo: either ADDR... or --listen ADDR");
  return has_arguments ? Echo(context).subscribe() : Echo(context).listen();
}

}  // namespace timsctl

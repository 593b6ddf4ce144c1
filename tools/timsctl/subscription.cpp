#include "tools/timsctl/subscription.h"

#include <algorithm>
#include <array>

#include "os/clock.h"
#include "os/wakeup.h"
#include "rack/codec/codec.h"
#include "rack/proxies/generic.h"
#include "tools/cli/failure.h"

namespace timsctl {

using namespace std::chrono_literals;

namespace {

// A component that is off, or not there, may come any moment; one that has gone silent may have
// been restarted and know nothing of us.
constexpr tims::Duration kAskOffAgain = 1s;
constexpr tims::Duration kAskSilentAgain = 10s;
constexpr tims::Duration kStopPatience = 300ms;
constexpr std::uint8_t kStopPriority = 255;  // its answer must not be lost behind data

template <rack::Struct Body>
tims::Result<void> send(Connection& connection, const tims::Envelope& envelope, const Body& body) {
  std::array<std::byte, rack::wire_size<Body>()> bytes{};
  if (const auto size = rack::encode(body, bytes); !size) return size.error();
  return connection.send(envelope, bytes);
}

}  // namespace

std::string_view Subscription::state_name() const {
  constexpr std::array<std::string_view, 4> kNames = {"asking", "on", "off", "no_mailbox"};
  return kNames[static_cast<std::size_t>(state_)];
}

tims::Result<void> Subscription::on_time(Connection& connection, tims::Time now) {
  if (now < next_question_) return {};
  next_question_ = now + kAskOffAgain;
  asked_ = true;
  return send(connection, {.dest = component_, .type = tims::type::kGetContData},
              rack::GetContDataRequest{period_ms_, connection.address()});
}

void Subscription::heard(State state, tims::Time ask_again_at) {
  state_ = state;
  next_question_ = ask_again_at;
}

bool Subscription::on_message(const Message& message, tims::Time now) {
  switch (message.header.type) {
    case tims::type::kContData:
      if (const auto reply = rack::decode<rack::ContDataReply>(message.view()))
        granted_ms_ = reply->periodTime;
      heard(State::kRunning, now + kAskSilentAgain);
      return false;
    case tims::type::kError:
      heard(State::kOff, now + kAskOffAgain);
      return false;
    case tims::type::kNotAvailable:
      heard(State::kNoMailbox, now + kAskOffAgain);
      return false;
    case tims::type::kOk:
      return false;
    default:
      heard(State::kRunning,
            now + std::max<tims::Duration>(kAskSilentAgain,
                                           3 * std::chrono::milliseconds(granted_ms_.value_or(0))));
      return true;
  }
}

void Subscription::stop(Connection& connection) const {
  (void)send(connection,
             {.dest = component_, .type = tims::type::kStopContData, .priority = kStopPriority},
             rack::StopContDataRequest{connection.address()});
}

Subscriptions::Subscriptions(Connection& connection, const std::vector<tims::Address>& components,
                             std::uint32_t period_ms)
    : connection_(connection) {
  for (const tims::Address component : components) list_.emplace_back(component, period_ms);
}

Subscriptions::~Subscriptions() {
  try {
    finish();
  } catch (const std::exception&) {
    // The connection is lost: there is nobody left to tell.
  }
}

std::optional<Subscriptions::Data> Subscriptions::next(const Signals& signals,
                                                       tims::Time deadline) {
  for (;;) {
    const tims::Time now = tims::os::now();
    if (now >= deadline) return std::nullopt;
    tims::Time until = deadline;
    for (Subscription& subscription : list_) {
      if (auto sent = subscription.on_time(connection_, now); !sent)
        throw failure_of(sent.error(), subscription.component().to_string(connection_.widths()));
      until = std::min(until, subscription.next_time());
    }
    auto message = receive(connection_, signals, until);
    if (!message) continue;
    const auto from = std::ranges::find(list_, message->header.src, &Subscription::component);
    if (from == list_.end()) continue;
    const tims::Time at = tims::os::now();
    if (from->on_message(*message, at))
      return Data{static_cast<std::size_t>(from - list_.begin()), std::move(*message), at};
  }
}

// Ctrl-C may have been what brought us here: signals are not looked at.
void Subscriptions::finish() {
  std::size_t open = 0;
  for (const Subscription& subscription : list_) {
    if (!subscription.needs_stop()) continue;
    subscription.stop(connection_);
    ++open;
  }
  const tims::Time deadline = tims::os::deadline_after(kStopPatience);
  while (open > 0 && tims::os::now() < deadline) {
    auto message = connection_.take();
    if (message) {
      const std::int8_t type = message->header.type;
      if (type == tims::type::kOk || type == tims::type::kNotAvailable) --open;
      continue;
    }
    if (message.error().code() != tims::Errc::kEmpty) return;
    (void)tims::os::is_readable(connection_.descriptor(), 20ms);
  }
}

}  // namespace timsctl

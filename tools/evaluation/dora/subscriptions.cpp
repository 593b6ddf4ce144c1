#include "tools/evaluation/dora/subscriptions.h"

#include <algorithm>

#include "os/clock.h"
#include "rack/proxies/proxy.h"
#include "rack/proxies/world.h"
#include "tools/cli/failure.h"
#include "tools/evaluation/dora/reference.h"

namespace rack::dora {
namespace {

using namespace std::chrono_literals;

constexpr int kPriority = 90;
constexpr std::uint32_t kLargest = 256U << 10;
constexpr Duration kResubscribe = 300ms;
constexpr Duration kPoll = 100ms;  // interval of checks of ending_

tims::Session connect(const std::string& socket) {
  return timsctl::value_or_fail(
      tims::Session::connect({.name = "rack-dora",
                              .router = socket,
                              .timeout = 10s,
                              .on_event = [](const tims::SessionEvent&) {}}),
      socket);
}

tims::Mailbox open_at(tims::Session& session, tims::MailboxOptions options) {
  const auto widths = session.address_widths();
  const std::uint32_t system = session.router().fields(widths).system;
  for (int taken = 1;; ++taken) {
    options.address = timsctl::mailbox_address({}, system, widths);
    auto mailbox = session.open(options);
    if (mailbox) return std::move(*mailbox);
    if (mailbox.error().code() != tims::Errc::kAddressInUse || !timsctl::may_draw_again({}, taken))
      throw timsctl::failure_of(mailbox.error(), "cannot open a mailbox");
  }
}

}  // namespace

tims::Address address_of(std::string_view component) {
  constexpr std::string_view kWorldPrefix = "World(";  // the original RACK has no such class
  if (component.starts_with(kWorldPrefix))
    return tims::Address::of({.system = 1, .class_id = kWorld});
  const auto address = tims::Address::parse(component);
  if (!address) throw timsctl::usage_error(std::string(component) + " is not a component address");
  return *address;
}

Subscriptions::Subscriptions(std::string_view host, const std::string& socket, OnMessage on_message)
    : on_message_(std::move(on_message)), session_(connect(socket)) {
  work_.emplace(open({.slots = 16, .body_max = 1U << 20}));
  stream_.emplace(open({.slots = 256, .body_max = kLargest}));
  for (std::size_t i = 0; i < kStreams.size(); ++i) {
    if (kStreams.at(i).host != host) continue;
    auto subscription = std::make_unique<Subscription>();
    subscription->stream = i;
    subscription->component = address_of(kStreams.at(i).component);
    const auto period = std::chrono::duration<double, std::milli>(kStreams.at(i).period_ms);
    subscription->timeout =
        std::max(kResubscribe, std::chrono::duration_cast<Duration>(period) * 5 / 2);
    subscribed_.push_back(std::move(subscription));
  }
  const std::string name = std::string("rx ") + std::string(host.substr(host.find('-') + 1));
  real_time_ = start_thread(thread_, name, kPriority, [this] { receive(); });
}

Subscriptions::~Subscriptions() {
  ending_ = true;
  thread_.join();
}

tims::Mailbox Subscriptions::open(const tims::MailboxOptions& options) {
  return open_at(session_, options);
}

void Subscriptions::receive() {
  while (!ending_) {
    const auto message = stream_->peek_for(kPoll);
    if (!message) continue;
    const Time now = tims::os::now();
    const tims::MessageView view{message->header(), message->body()};
    const auto from = std::ranges::find_if(subscribed_, [&](const auto& subscription) {
      return subscription->component == view.header.src;
    });
    if (from == subscribed_.end()) continue;
    (*from)->last_received = now.time_since_epoch().count();
    if (view.header.type == tims::type::kData || view.header.type == tims::type::kError)
      on_message_((*from)->stream, view, now);
  }
}

void Subscriptions::renew() {
  for (const auto& subscription : subscribed_) {
    const Time now = tims::os::now();
    const Time last{Duration(subscription->last_received.load())};
    if (now - std::max(last, subscription->requested) < subscription->timeout) continue;
    subscription->requested = now;
    Proxy proxy(*work_, subscription->component);
    (void)proxy.get_cont_data(0, stream_->address());
  }
}

}  // namespace rack::dora

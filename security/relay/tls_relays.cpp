#include "security/relay/tls_relays.h"

#include <algorithm>
#include <utility>

#include "os/clock.h"
#include "os/wakeup.h"

namespace tims::security {

Result<std::unique_ptr<TlsRelays>> TlsRelays::start(RelayLimits limits) {
  auto event = os::make_event_fd();
  if (!event) return event.error();
  return std::unique_ptr<TlsRelays>(new TlsRelays(std::move(*event), limits));
}

TlsRelays::TlsRelays(os::File event, RelayLimits limits)
    : limits_(limits), event_(std::move(event)), thread_([this] { run(); }) {}

TlsRelays::~TlsRelays() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  os::signal_event_fd(event_.get());
  thread_.join();
}

void TlsRelays::add(Relayed what) {
  const auto shared = std::make_shared<Relayed>(std::move(what));
  give([this, shared](Time now) { begin(now, std::move(*shared)); });
}

void TlsRelays::end_if(std::function<bool(const Chain&)> which) {
  give([this, which = std::move(which)](Time) {
    relays_.remove_if([&](const TlsRelay& relay) {
      const bool is_one = which(relay.chain());
      if (is_one) relay.tell_end();
      return is_one;
    });
  });
}

void TlsRelays::give(Order order) {
  {
    const std::lock_guard lock(mutex_);
    orders_.push_back(std::move(order));
  }
  os::signal_event_fd(event_.get());
}

void TlsRelays::run() {
  for (;;) {
    wait();
    os::drain_event_fd(event_.get());
    {
      const std::lock_guard lock(mutex_);
      if (stopping_) return;
    }
    work();
    obey(os::now());
  }
}

void TlsRelays::obey(Time now) {
  std::vector<Order> orders;
  {
    const std::lock_guard lock(mutex_);
    orders.swap(orders_);
  }
  for (const Order& order : orders) order(now);
}

void TlsRelays::begin(Time now, Relayed what) {
  TlsRelay& relay = relays_.emplace_back(std::move(what), now + limits_.handshake_time);
  relay.work(now);
  tidy();
}

void TlsRelays::tidy() {
  make_room(TlsRelay::State::kHandshake, limits_.handshakes_max);
  make_room(TlsRelay::State::kFirstByte, limits_.first_bytes_max);
  relays_.remove_if([](const TlsRelay& relay) {
    const bool is_over = relay.state() == TlsRelay::State::kOver;
    if (is_over) relay.tell_end();
    return is_over;
  });
}

void TlsRelays::make_room(TlsRelay::State state, std::size_t most) {
  const auto is_one = [&](const TlsRelay& relay) { return relay.state() == state; };
  for (auto n = std::ranges::count_if(relays_, is_one); n > static_cast<std::ptrdiff_t>(most);
       --n) {
    const auto oldest = std::ranges::find_if(relays_, is_one);
    oldest->tell_end();
    relays_.erase(oldest);
  }
}

void TlsRelays::wait() {
  waits_.assign(1, {event_.get(), POLLIN, 0});
  Time next = kNever;
  for (const TlsRelay& relay : relays_) {
    waits_.push_back({relay.outer(), relay.outer_events(), 0});
    // Without a wish, a connection that has ended would wake again and again.
    const short inner = relay.inner_events();
    waits_.push_back({inner == 0 ? -1 : relay.inner(), inner, 0});
    if (waits_[waits_.size() - 2].events == 0) waits_[waits_.size() - 2].fd = -1;
    next = std::min(next, relay.deadline());
  }
  (void)os::poll_until(waits_, next);
}

void TlsRelays::work() {
  const Time now = os::now();
  std::size_t at = 1;
  for (TlsRelay& relay : relays_) {
    const bool ready = waits_[at].revents != 0 || waits_[at + 1].revents != 0;
    at += 2;
    if (ready) relay.work(now);
    if (relay.state() != TlsRelay::State::kOver && relay.deadline() <= now) relay.on_deadline();
  }
  tidy();
}

}  // namespace tims::security

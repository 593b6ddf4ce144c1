#include "router/io/link_port.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include <fmt/core.h>

#include "os/clock.h"
#include "router/io/acceptor.h"
#include "router/io/net/addresses.h"

namespace tims::io {
namespace {

std::string dds_interface(const config::Config& config) {
  return config.dds_leaves_host() ? "" : "127.0.0.1";
}

DdsSettings dds_settings(const config::Config& config) {
  return {.fleet = config.fleet.name,
          .domain = config.dds.domain,
          .multicast = config.dds.multicast,
          .peers = config::list_of(config.dds.peers),
          .discovery_server = config.dds.server,
          .interface = dds_interface(config),
          .profiles = config.dds.profiles,
          .lease = config.dds.lease,
          .message_max = config.dds.message_max,
          .history = config.dds.history,
          .heartbeat = config.dds.heartbeat};
}

using namespace std::chrono_literals;

constexpr std::size_t kPartsBytesMin = 256 << 20;
// While links do not come up, their host names may have changed their meaning.
constexpr Duration kResolveEvery = 2s;
constexpr Duration kWallClockEvery = 100ms;

policy::Lifetimes lifetimes_of(const config::Config& config) {
  policy::Lifetimes lifetimes(config.address.widths);
  // The configuration was checked.
  for (const std::string& lifetime : config::list_of(config.message.lifetimes))
    (void)lifetimes.add(lifetime);
  return lifetimes;
}

link::LinkSettings link_settings(const config::Link& from, const config::Config& config) {
  return {.kind = from.kind,
          .connects = !from.accepts(),
          .to = from.accepts() ? std::string() : from.to_string(),
          .system = from.system,
          .paths = from.paths,
          .mailboxes_max = from.mailboxes,
          .keep_alive = from.interval,
          .packing = {.compress = from.compress, .own_classes = from.compress_own},
          .secure = from.secure,
          .session = {.message_max = config.message.bytes_max,
                      .queue_bytes_max =
                          std::max<std::uint64_t>(config.tcp.queue_bytes, config.message.bytes_max),
                      .lifetime = from.lifetime,
                      .rate = from.rate,
                      .reserve = from.reserve,
                      .lifetimes = lifetimes_of(config)}};
}

// Memory: the reserve for one message of maximum size, and more for others.
std::size_t parts_bytes(std::uint32_t message_max) {
  return std::max(kPartsBytesMin, 4 * link::MessageMemory::place_bytes(message_max));
}

// Address space, which costs nothing.
std::size_t parts_space(std::uint32_t message_max) {
  return link::MessageMemory::kPlacesMax * link::MessageMemory::place_bytes(message_max);
}

// Its peer's name or the address it is to be established to, as in a question.
bool has_name(const link::Link& link, std::string_view name) {
  return link.peer().name.view() == name || link.settings().to == name;
}

}  // namespace

DdsPath::DdsPath(Loop& loop, Log& log, link::Links& links, const config::Config& config)
    : loop_(loop),
      log_(log),
      links_(links),
      self_{.fleet = std::string_view(config.fleet.name), .identity = links.self()},
      engine_(loop, log, dds_settings(config), *this) {}

Result<void> DdsPath::start(std::vector<link::NetAddress> udp) {
  self_.udp = std::move(udp);
  return engine_.start(self_);
}

void DdsPath::network_changed(std::vector<link::NetAddress> udp) {
  if (udp == self_.udp && !is_outdated()) return;
  self_.udp = std::move(udp);
  engine_.restart(self_);
}

// What the participant announces is compared, and not what the host had when the creation of the
// participant was requested: an address or a carrier may come in between.
bool DdsPath::is_outdated() const {
  if (engine_.state() != DdsEngine::State::kUp) return true;
  return !engine_.host().empty() && engine_.host() != host_addresses();
}

void DdsPath::on_datagram(const link::NetAddress& from, std::span<std::byte> datagram) {
  links_.on_datagram(os::now(), from, datagram);
}

void DdsPath::on_announced(const link::Announcement& announcement) {
  links_.on_announced(os::now(), announcement);
  links_.for_each([&](const link::Link& link) {
    if (link.paths().is_target(announcement.dds)) engine_.connect(announcement.dds);
  });
}

void DdsPath::on_gone(const link::NetAddress& dds) { links_.on_gone(os::now(), dds); }

void DdsPath::on_state() {
  std::string trouble;
  if (engine_.state() != DdsEngine::State::kUp)
    trouble = fmt::format("{}{}{}", name(engine_.state()), engine_.last_error().empty() ? "" : ": ",
                          engine_.last_error());
  if (!trouble.empty() && trouble != links_.trouble(link::PathKind::kDds))
    log_.warning("dds is " + trouble);
  links_.set_trouble(link::PathKind::kDds, std::move(trouble));
  if (engine_.state() == DdsEngine::State::kUp && is_outdated()) engine_.restart(self_);
}

void DdsPath::on_turn_end() { loop_.end_turn(os::now()); }

LinkPort::LinkPort(Loop& loop, core::Router& router, Log& log, core::BlockPool& pool,
                   const link::LinksSetup& setup, const std::string& keys, OnList on_list)
    : loop_(loop),
      log_(log),
      on_list_(std::move(on_list)),
      handshaker_(keys.empty() ? nullptr : make_handshaker()),
      list_keeper_(keys.empty() ? nullptr : make_list_keeper(keys)),
      parts_(parts_space(setup.self.message_max)),
      memory_(parts_.bytes(), setup.self.message_max, parts_bytes(setup.self.message_max)),
      links_(router, pool, memory_, with_keys(setup), this),
      resolver_(loop),
      interfaces_(loop, [this] { on_network_change(); }) {}

link::LinksSetup LinkPort::with_keys(link::LinksSetup setup) const {
  setup.handshaker = handshaker_.get();
  setup.lists = list_keeper_.get();
  return setup;
}

std::unique_ptr<ListKeeper> LinkPort::make_list_keeper(const std::string& keys) {
  return std::make_unique<ListKeeper>(security::KeyFolder(keys), [this](CheckedList&& list) {
    loop_.post([this, shared = std::make_shared<CheckedList>(std::move(list))] {
      on_list_checked(std::move(*shared));
    });
  });
}

void LinkPort::on_list_checked(CheckedList&& list) {
  const Time now = os::now();
  const bool is_good = list.refused.empty();
  if (!is_good)
    log_.warning(fmt::format("list {} of the fleet, from {}, is refused: {}", list.number,
                             list.from, list.refused));
  links_.on_list_checked(now, list.transfer, is_good);
  if (is_good) on_list_(now, std::move(list));
  loop_.end_turn(now);
}

std::unique_ptr<TlsHandshaker> LinkPort::make_handshaker() {
  return std::make_unique<TlsHandshaker>([this](link::HandshakeProgress&& progress) {
    loop_.post([this, shared = std::make_shared<link::HandshakeProgress>(std::move(progress))] {
      const Time now = os::now();
      links_.on_handshake(now, std::move(*shared));
      loop_.end_turn(now);
    });
  });
}

Result<void> LinkPort::use_keys(Time now, const security::Credentials& credentials,
                                const security::Strictness& strictness) {
  if (auto ready = handshaker_->set_credentials(credentials, strictness); !ready) return ready;
  list_keeper_->set_credentials(credentials);
  std::vector<security::Certificate> shown = credentials.chain;
  shown.insert(shown.end(), credentials.roots.begin(), credentials.roots.end());
  if (shown != shown_) links_.renew_keys(now);
  shown_ = std::move(shown);
  links_.use_list(now,
                  {.number = credentials.list_number(),
                   .bytes = std::make_shared<const security::Bytes>(credentials.list_bytes)},
                  [list = credentials.list, roots = security::BelievedRoots(credentials.roots)](
                      const link::PeerName& peer) mutable {
                    const auto named = security::Revoked::from_bytes(peer.certificate);
                    if (!named || (list && list->revokes(*named))) return link::Standing::kRevoked;
                    return roots.have_signed(peer.issuer) ? link::Standing::kGood
                                                          : link::Standing::kOldRoot;
                  });
  return {};
}

Result<void> LinkPort::check_memory() const {
  const std::uint32_t message_max = links_.self().message_max;
  if (memory_.is_enough()) return {};
  return Error(
      Errc::kSystem,
      fmt::format("cannot reserve {} bytes of address space for messages in parts "
                  "(ulimit -v): lower message.max ({} bytes)",
                  link::MessageMemory::kPlacesMin * std::size_t{message_max}, message_max));
}

void LinkPort::release() {
  if (tcp_) tcp_->flush();
  links_.release();
  for (auto bytes = memory_.surplus(); !bytes.empty(); bytes = memory_.surplus())
    WaitingMemory::discard(bytes);
}

Result<std::string> LinkPort::listen(const config::Endpoint& where, os::SocketStore& store) {
  if (auto result = check_memory(); !result) return result.error();
  auto socket = UdpSocket::open(where, {}, &store);
  if (!socket) return socket.error();
  socket_ = std::move(*socket);
  if (socket_->is_early()) log_.warning(waits_for_address("udp", where));
  const std::uint32_t asked = socket_->asked_buffer_bytes();
  if (socket_->receive_buffer_bytes() < asked || socket_->send_buffer_bytes() < asked) {
    log_.info(fmt::format(
        "udp buffers are {} KiB in, {} KiB out, less than the {} KiB requested: "
        "bursts may be lost; raise net.core.rmem_max and wmem_max",
        socket_->receive_buffer_bytes() >> 10, socket_->send_buffer_bytes() >> 10, asked >> 10));
  }
  watch_network();
  watch_.emplace(loop_, socket_->fd(), [this](Ready ready) { on_ready(ready); });
  choose_sender();
  return socket_->local().to_string();
}

Result<void> LinkPort::join(const config::Config& config) {
  if (auto result = check_memory(); !result) return result;
  watch_network();
  dds_.emplace(loop_, log_, links_, config);
  links_.set_sender(link::PathKind::kDds, &*dds_);
  return dds_->start(udp_addresses());
}

Result<std::string> LinkPort::open_tcp(const config::Config& config, os::SocketStore& store) {
  const auto has_it = [](const config::Link& link) { return link.uses(link::PathKind::kTcp); };
  const auto accepts = [&](const config::Link& link) { return has_it(link) && link.accepts(); };
  if (std::ranges::none_of(config.links, has_it)) return std::string();
  if (!tcp_) {
    if (auto result = check_memory(); !result) return result.error();
    watch_network();
    TcpPath::Listener& listener = *this;
    tcp_.emplace(loop_, log_, listener);
    links_.set_sender(link::PathKind::kTcp, &*tcp_);
  }
  if (tcp_->listens() || !socket_ || std::ranges::none_of(config.links, accepts))
    return std::string();
  const auto where = tcp_->listen({config.udp.listen->host, socket_->local().port}, &store);
  if (!where) return where.error();
  return where->to_string();
}

std::vector<link::NetAddress> LinkPort::udp_addresses() const {
  return socket_ ? own_addresses(socket_->local()) : std::vector<link::NetAddress>();
}

void LinkPort::watch_network() {
  if (std::exchange(watches_network_, true)) return;
  if (const auto watching = interfaces_.start(); !watching)
    log_.warning("cannot watch the network for changes: " + watching.error().detail());
}

void LinkPort::configure(Time now, const config::Config& config) {
  std::vector<link::LinkSettings> wanted;
  names_.clear();
  for (const config::Link& link : config.links) {
    wanted.push_back(link_settings(link, config));
    if (!link.accepts() && !link.is_automatic()) names_[wanted.back().to] = {link.host, link.port};
  }
  links_.configure(now, wanted);
  if (!config.sim.faults) clear_faults();
  resolve(now);
}

// --- names

void LinkPort::resolve(Time now) {
  const auto wanted = links_.names_to_resolve();
  for (const std::string& to : wanted) resolve_one(to);
  next_resolve_ = wanted.empty() ? now + 5 * kResolveEvery : now + kResolveEvery;
  if (names_.empty()) next_resolve_ = kNever;
}

void LinkPort::resolve_one(const std::string& to) {
  const auto name = names_.find(to);
  if (name == names_.end()) return;
  const auto& [host, port] = name->second;
  resolver_.resolve(host, port, [this, to](const Result<Resolver::Addresses>& addresses) {
    const Time now = os::now();
    if (!addresses)
      return log_.warning(fmt::format("link to {}: {}", to, addresses.error().detail()));
    const Resolver::Addresses good = reachable(*addresses);
    if (good.empty()) {
      note_unreachable(to, *addresses);
      return continue_later();
    }
    // One after the other, when the first does not answer.
    const std::size_t n = tries_[to]++;
    links_.set_target(now, to, good[n % good.size()]);
    continue_later();
  });
}

Resolver::Addresses LinkPort::reachable(const Resolver::Addresses& addresses) const {
  Resolver::Addresses good;
  std::ranges::copy_if(addresses, std::back_inserter(good), [this](const link::NetAddress& to) {
    return !socket_ || socket_->can_reach(to);
  });
  return good;
}

void LinkPort::note_unreachable(const std::string& to, const Resolver::Addresses& addresses) {
  std::string list;
  for (const link::NetAddress& address : addresses)
    list += (list.empty() ? "" : ", ") + address.to_string();
  const std::string why =
      fmt::format("its address is {}, which the socket of udp.listen = \"{}\" cannot reach", list,
                  socket_->local().to_string());
  log_.warning(fmt::format("link to {}: {}", to, why));
  links_.note_unreachable(to, why);
}

void LinkPort::on_network_change() {
  const Time now = os::now();
  if (socket_) socket_->forget_refusals();
  if (dds_) dds_->network_changed(udp_addresses());
  links_.network_changed(now);
  resolve(now);
  loop_.end_turn(now);
}

// --- incoming datagrams

void LinkPort::on_ready(Ready ready) {
  const Time now = os::now();
  if (ready.to_write) watch_->set(Interest::kReading);
  if (ready.to_read && socket_->receive(datagrams_)) take_datagrams(now);
  if (ready.to_read && datagrams_.took_all()) watch_->all_taken();
  loop_.end_turn(now);
}

void LinkPort::take_datagrams(Time now) {
  read_wall_clock(now);
  datagrams_.for_each_datagram([&](const link::NetAddress& from, std::span<std::byte> datagram) {
    links_.on_datagram(now, from, datagram);
  });
}

void LinkPort::read_wall_clock(Time now) {
  if (now < wall_read_ + kWallClockEvery) return;
  wall_read_ = now;
  const auto wall = std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now());
  links_.set_wall(wall.time_since_epoch().count() - os::now().time_since_epoch().count());
}

// --- over TCP

void LinkPort::on_tcp_datagram(const link::NetAddress& from, std::span<std::byte> datagram) {
  links_.on_datagram(os::now(), from, datagram);
}

void LinkPort::on_tcp_gone(const link::NetAddress& address) { links_.on_gone(os::now(), address); }

void LinkPort::on_tcp_turn_end() { loop_.end_turn(os::now()); }

bool LinkPort::is_called(const link::NetAddress& address) const {
  bool found = false;
  links_.for_each([&](const link::Link& link) { found |= link.paths().is_target(address); });
  return found;
}

bool LinkPort::is_linked(const link::NetAddress& address) const {
  bool found = false;
  links_.for_each(
      [&](const link::Link& link) { found |= link.is_up() && link.paths().is_at(address); });
  return found;
}

// --- outgoing datagrams

void LinkPort::wait_for_sender() { watch_->set(Interest::kBoth); }

// Lets other components have their turn first.
void LinkPort::continue_later() {
  if (std::exchange(continues_, true)) return;
  loop_.post([this] {
    continues_ = false;
    loop_.end_turn(os::now());
  });
}

bool LinkPort::act(std::string_view name, link::Links::Action what) {
  if (!links_.has(name)) return false;
  loop_.post([this, name = std::string(name), what] {
    const Time now = os::now();
    (void)links_.act(now, name, what);
    loop_.end_turn(now);
  });
  return true;
}

void LinkPort::end(Time now) {
  links_.end(now);
  links_.flush(now);
  if (tcp_) tcp_->flush();
}

std::size_t LinkPort::restore(Time now, link::Handover former) {
  if (watch_) watch_->set(Interest::kNothing);
  return links_.restore(now, std::move(former));
}

void LinkPort::receive_again() {
  if (watch_) watch_->set(Interest::kReading);
}

void LinkPort::stop() {
  if (dds_) dds_->stop();
}

// --- read access

std::optional<UdpReport> LinkPort::udp_report() const {
  if (!socket_) return std::nullopt;
  return UdpReport{.asked_buffer_bytes = socket_->asked_buffer_bytes(),
                   .receive_buffer_bytes = socket_->receive_buffer_bytes(),
                   .send_buffer_bytes = socket_->send_buffer_bytes(),
                   .dropped_by_kernel = socket_->counters().dropped_by_kernel,
                   .strange = links_.counters().strange,
                   .unknown_token = links_.counters().unknown_token,
                   .refused = links_.counters().refused,
                   .handshakes = links_.counters().handshakes};
}

std::optional<DdsReport> LinkPort::dds_report() const {
  if (!dds_) return std::nullopt;
  const DdsProcess& engine = dds_->engine();
  const DdsProcess::Counters counters = engine.counters();
  return DdsReport{.state = std::string(name(engine.state())),
                   .trouble = engine.last_error(),
                   .address = engine.address() ? engine.address().to_string() : "",
                   .samples_in = counters.samples_in,
                   .samples_out = counters.samples_out,
                   .datagrams_in = counters.datagrams_in,
                   .datagrams_out = counters.datagrams_out,
                   .strange = counters.strange,
                   .refused = counters.refused,
                   .unmatched = counters.unmatched,
                   .waiting_bytes = counters.waiting_bytes};
}

// --- time

Time LinkPort::next_timeout() const {
  Time next = std::min(links_.next_timeout(), next_resolve_);
  if (!delayed_.empty()) next = std::min(next, delayed_.top().at);
  if (tcp_) next = std::min(next, tcp_->next_timeout());
  return is_open() ? next : kNever;
}

void LinkPort::on_timeout(Time now) {
  read_wall_clock(now);
  while (!delayed_.empty() && delayed_.top().at <= now) {
    const Delayed& next = delayed_.top();
    (void)socket_->send({.to = next.to, .bytes = next.bytes, .datagram_size = next.bytes.size()});
    delayed_.pop();
  }
  if (now >= next_resolve_) resolve(now);
  if (tcp_) tcp_->on_timeout(now);
  links_.on_timeout(now);
}

// --- fault injection

bool LinkPort::inject_faults(std::string_view name, const link::Faults& faults) {
  const bool off = faults == link::Faults();
  const auto seed = static_cast<std::uint64_t>(os::now().time_since_epoch().count());
  if (name.empty()) {
    clear_faults();
    if (!off) injected_everywhere_.emplace(seed).set(faults);
    choose_sender();
    return true;
  }
  // It may have had other addresses at the previous request.
  bool found = std::erase_if(injected_, [&](const auto& i) { return i.second.link == name; }) > 0;
  links_.for_each([&](const link::Link& link) {
    if (!has_name(link, name)) return;
    found = true;
    std::vector<link::NetAddress> places = link.paths().to_call(false);
    if (link.address()) places.push_back(link.address());
    for (const link::NetAddress& to : places) {
      if (to.kind != link::PathKind::kUdp) continue;
      injected_.erase(to);
      if (off) continue;
      const auto added = injected_.insert({to, {std::string(name), link::FaultInjector(seed)}});
      added.first->second.faults.set(faults);
    }
  });
  choose_sender();
  return found;
}

const link::Faults* LinkPort::faults_of(const link::Link& link) const {
  for (const auto& [to, injected] : injected_)
    if (has_name(link, injected.link)) return &injected.faults.faults();
  return injected_everywhere_ ? &injected_everywhere_->faults() : nullptr;
}

void LinkPort::clear_faults() {
  injected_.clear();
  injected_everywhere_.reset();
  choose_sender();
}

void LinkPort::choose_sender() {
  if (!socket_) return;
  const bool faulty = !injected_.empty() || injected_everywhere_;
  links_.set_sender(link::PathKind::kUdp,
                    faulty ? static_cast<link::DatagramSender*>(this) : &*socket_);
}

bool LinkPort::offer(const link::Burst& burst) {
  const auto found = injected_.find(burst.to);
  if (found == injected_.end() && !injected_everywhere_) return socket_->offer(burst);
  link::FaultInjector& faults =
      found == injected_.end() ? *injected_everywhere_ : found->second.faults;
  const Time now = os::now();
  burst.for_each([&](std::span<const std::byte> one) {
    const auto copies = faults.send(now, one.size());
    for (std::size_t i = 0; i < copies.count; ++i)
      delayed_.push({copies.at[i], ++order_, burst.to, {one.begin(), one.end()}});
  });
  return true;
}

}  // namespace tims::io

#include "tests/bench/fleet.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include <sys/epoll.h>

#include "libtims/os/clock.h"
#include "libtims/os/wakeup.h"
#include "router/core/random.h"
#include "router/io/crypto/tls_handshaker.h"
#include "router/io/net/addresses.h"
#include "router/io/net/udp_socket.h"
#include "router/io/waiting_memory.h"
#include "router/link/links.h"
#include "tests/bench/fleet_keys.h"

namespace tims::bench {
namespace {

constexpr std::size_t kMemory = 1 << 20;

link::Identity identity(std::uint32_t number, std::uint64_t epoch) {
  constexpr std::uint32_t kOfOneSystem = 4;  // because there are more robots than system numbers
  return {.epoch = epoch,
          .role = core::Role::kSystem,
          .system = static_cast<std::uint8_t>(number / kOfOneSystem + 1),
          .id = static_cast<std::uint8_t>(number % kOfOneSystem + 1),
          .name = std::string_view("robot" + std::to_string(number)),
          .message_max = kMessageMaxDefault};
}

// What the handshakes of all robots have brought; each robot has a thread for them, as a router
// has.
class Progress {
 public:
  void add(std::size_t robot, link::HandshakeProgress&& progress) {
    {
      const std::lock_guard lock(mutex_);
      all_.emplace_back(robot, std::move(progress));
    }
    os::signal_event_fd(wake_.get());
  }
  [[nodiscard]] int descriptor() const { return wake_.get(); }  // readable: there is some
  std::vector<std::pair<std::size_t, link::HandshakeProgress>> take() {
    os::drain_event_fd(wake_.get());
    const std::lock_guard lock(mutex_);
    return std::exchange(all_, {});
  }

 private:
  os::File wake_ = std::move(*os::make_event_fd());
  std::mutex mutex_;
  std::vector<std::pair<std::size_t, link::HandshakeProgress>> all_;
};

// What a robot with keys has of them.
struct Member {
  std::unique_ptr<link::Handshaker> handshaker{};
  link::FleetListBytes list{};
};

class Robot final : core::Port, core::RouterHooks, link::DatagramSender, link::ListKeeper {
 public:
  // `member`: empty without keys.
  Robot(const link::Identity& self, std::uint64_t seed, io::UdpSocket socket, Member member)
      : socket_(std::move(socket)),
        handshaker_(std::move(member.handshaker)),
        memory_(parts_.bytes(), kMessageMaxDefault, 4 * std::size_t{kMessageMaxDefault}),
        router_({.address = self.address()}, {self.epoch, seed}, *this),
        links_(router_, blocks_.pool(), memory_,
               {.self = self,
                .secret = {seed, seed},
                .handshaker = handshaker_.get(),
                .lists = handshaker_ == nullptr ? nullptr : this}) {
    router_.attach(core::PortKind::kLocal, *this);
    router_.attach(core::PortKind::kLink, links_);
    links_.set_sender(link::PathKind::kUdp, this);
    links_.use_list({}, std::move(member.list),
                    [](const link::PeerName&) { return link::Standing::kGood; });
  }

  void start(Time now, const link::NetAddress& base) {
    const core::ClientId client = router_.connect(now, {.port = core::PortKind::kLocal});
    const Address own = router_.settings().address;
    for (std::uint32_t i = 0; i < kMailboxesOfRobot; ++i) {
      const auto [system, none, id, zero] = own.fields();
      router_.register_mailbox(
          now, client,
          Address::of({.system = system, .class_id = 0x20, .instance = id, .local = i}));
    }
    const link::LinkSettings up{
        .kind = core::LinkKind::kSuper, .to = base.to_string(), .secure = handshaker_ != nullptr};
    links_.configure(now, std::span(&up, 1));
    links_.set_target(now, up.to, base);
    end_turn(now);
  }
  [[nodiscard]] int descriptor() const { return socket_.fd(); }
  [[nodiscard]] Time next_timeout() const { return links_.next_timeout(); }

  void on_input(Time now, io::Datagrams& datagrams) {
    if (socket_.receive(datagrams)) {
      datagrams.for_each_datagram([&](const link::NetAddress& from, std::span<std::byte> bytes) {
        links_.on_datagram(now, from, bytes);
      });
    }
    end_turn(now);
  }
  void on_handshake(Time now, link::HandshakeProgress&& progress) {
    links_.on_handshake(now, std::move(progress));
    end_turn(now);
  }
  void on_timeout(Time now) {
    links_.on_timeout(now);
    end_turn(now);
  }

 private:
  void end_turn(Time now) {
    do {
      router_.flush(now);
    } while (links_.has_something_to_send());
    links_.release();
  }

  // Datagrams that a full socket refuses are lost, as on the wire.
  bool offer(const link::Burst& burst) override {
    (void)socket_.send(burst);
    return true;
  }
  core::Outcome deliver(Time, const core::Receiver&, const core::Message&) override {
    return core::Outcome::kDelivered;
  }
  void reply(Time, const core::Receiver&, const Header&) override {}
  void close(const core::Receiver&, core::CloseReason) override {}
  void admin(Time, core::ClientId, const core::Message&) override {}
  void traced(core::ClientId, core::ClientId, const core::Message&) override {}
  void event(const core::Event&) override {}
  // The base has the same list, which nobody replaces.
  void check(std::uint64_t, std::uint64_t, std::string_view, std::vector<std::byte>&&) override {}

  io::UdpSocket socket_;
  std::unique_ptr<link::Handshaker> handshaker_;
  io::WaitingMemory blocks_{kMemory};
  io::WaitingMemory parts_{link::MessageMemory::kPlacesMin * std::size_t{kMessageMaxDefault}};
  link::MessageMemory memory_;
  core::Router router_;
  link::Links links_;
};

class Fleet {
 public:
  // `keys`: folder of FleetKeys; empty: the links are open.
  explicit Fleet(std::string keys)
      : poller_(::epoll_create1(EPOLL_CLOEXEC)), keys_(std::move(keys)) {
    if (!keys_.empty()) watch(progress_.descriptor(), kHandshakes);
  }

  Result<void> add(const link::NetAddress& base) {
    const auto number = static_cast<std::uint32_t>(robots_.size());
    auto socket = io::UdpSocket::open({"127.0.0.1", 0});
    if (!socket) return socket.error();
    const link::Identity self = identity(number, core::next_random(random_));
    auto member = member_of(number, self);
    if (!member) return member.error();
    robots_.push_back(std::make_unique<Robot>(self, core::next_random(random_), std::move(*socket),
                                              std::move(*member)));
    watch(robots_.back()->descriptor(), number);
    robots_.back()->start(os::now(), base);
    wakes_.push_back(robots_.back()->next_timeout());
    return {};
  }

  [[noreturn]] void run() {
    std::array<epoll_event, 64> events{};
    for (;;) {
      const int n = ::epoll_wait(poller_.get(), events.data(), events.size(), milliseconds_left());
      for (int i = 0; i < n; ++i) {
        const std::uint64_t what = events[static_cast<std::size_t>(i)].data.u64;
        what == kHandshakes
            ? take_handshakes()
            : with(what, [this](Robot& robot) { robot.on_input(os::now(), datagrams_); });
      }
      const Time now = os::now();
      for (std::size_t robot = 0; robot < robots_.size(); ++robot)
        if (wakes_[robot] <= now) with(robot, [now](Robot& one) { one.on_timeout(now); });
    }
  }

 private:
  static constexpr std::uint64_t kHandshakes = ~std::uint64_t{0};

  // `what`: a robot, or kHandshakes.
  void watch(int descriptor, std::uint64_t what) const {
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.u64 = what;
    ::epoll_ctl(poller_.get(), EPOLL_CTL_ADD, descriptor, &event);
  }
  Result<Member> member_of(std::uint64_t number, const link::Identity& self) {
    if (keys_.empty()) return Member{};
    const auto folder =
        FleetKeys::folder_of(keys_, security::MemberRole::kSystem, self.system, self.id);
    const auto own = security::KeyFolder(folder).load();
    if (!own) return own.error();
    auto handshaker =
        std::make_unique<io::TlsHandshaker>([this, number](link::HandshakeProgress&& progress) {
          progress_.add(number, std::move(progress));
        });
    if (auto set = handshaker->set_credentials(*own, security::Strictness{}); !set)
      return set.error();
    return Member{.handshaker = std::move(handshaker),
                  .list = {.number = own->list_number(),
                           .bytes = std::make_shared<const security::Bytes>(own->list_bytes)}};
  }
  template <typename Act>
  void with(std::size_t robot, Act act) {
    act(*robots_[robot]);
    wakes_[robot] = robots_[robot]->next_timeout();
  }
  void take_handshakes() {
    for (auto& one : progress_.take())
      with(one.first, [&](Robot& robot) { robot.on_handshake(os::now(), std::move(one.second)); });
  }
  [[nodiscard]] int milliseconds_left() const {
    constexpr Duration kLongest = std::chrono::milliseconds(100);
    const Time now = os::now();
    const Time next = std::min(now + kLongest, *std::ranges::min_element(wakes_));
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(next - now);
    return static_cast<int>(std::max<std::int64_t>(0, left.count()));
  }

  os::File poller_;
  std::string keys_;
  Progress progress_;
  std::uint64_t random_ = static_cast<std::uint64_t>(os::now().time_since_epoch().count());
  std::vector<std::unique_ptr<Robot>> robots_;
  std::vector<Time> wakes_;  // of each robot; together, because all of them are looked at often
  io::Datagrams datagrams_;
};

}  // namespace

Result<void> make_keys_of_fleet(const FleetKeys& keys, std::uint64_t robots) {
  for (std::uint32_t i = 0; i < robots; ++i) {
    const link::Identity one = identity(i, 1);
    if (auto made = keys.add(security::MemberRole::kSystem, one.system, one.id); !made) return made;
  }
  return {};
}

bool play_fleet(const Plan& plan) {
  const auto base = config::Endpoint::parse(plan.endpoint);
  if (!base) return false;
  const auto address = io::numeric_address(base->host, base->port);
  Fleet fleet(plan.folder);
  for (std::uint64_t i = 0; i < plan.count; ++i) {
    if (auto added = fleet.add(*address); !added) {
      std::fprintf(stderr, "fleet: %s\n", added.error().message().c_str());
      return false;
    }
  }
  fleet.run();
}

}  // namespace tims::bench

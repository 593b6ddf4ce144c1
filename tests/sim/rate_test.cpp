// How well links use the capacity of a network, and how little they delay other messages.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <functional>

#include <gtest/gtest.h>

#include "tests/sim/simulated_network.h"

namespace tims::sim {
namespace rate_test {

using namespace std::chrono_literals;
using std::chrono::duration;

constexpr std::uint64_t kMbit = 125'000;

// Two routers, a sender at one and a receiver at the other.
struct Line : SimulatedNetwork {
  explicit Line(const Faults& faults, const link::LinkSessionSettings& session = {},
                std::uint64_t seed = 1)
      : SimulatedNetwork(seed) {
    auto up = super_link(address_of(0));
    up.session = session;
    base = &add({.name = "base", .role = core::Role::kTop, .links = {sub_link()}});
    robot = &add({.name = "robot", .system = 1, .links = {up}});
    set_faults(faults);
    base->start(now());
    robot->start(now());
    sink = base->add_client(now(), "sink");
    base->add_mailbox(now(), sink, kSink);
    source = robot->add_client(now(), "source");
    robot->add_mailbox(now(), source, kSource);
    base->on_arrival = [this](Node&, core::ClientId, Arrival&& arrival) { took(arrival); };
    run_for(2s);
  }

  void took(const Arrival& arrival) {
    bytes += arrival.header.length;
    ++messages;
    if (arrival.header.priority < kUrgent) return;
    std::int64_t sent = 0;
    std::memcpy(&sent, arrival.body.data(), sizeof(sent));
    delays.push_back(arrival.at.time_since_epoch() - Duration(sent));
  }
  core::Outcome send(std::uint8_t priority, std::size_t size) {
    std::vector<std::byte> body(size);
    const std::int64_t at = now().time_since_epoch().count();
    if (size >= sizeof(at)) std::memcpy(body.data(), &at, sizeof(at));
    return robot->send(now(), source,
                       {.type = -7, .priority = priority, .dest = kSink, .src = kSource}, body);
  }
  [[nodiscard]] std::uint64_t queued() const {
    std::uint64_t sum = 0;
    robot->links().for_each([&](const link::Link& l) { sum += l.session().queued_bytes(); });
    return sum;
  }
  // Keeps the queue filled with large messages of the lowest class.
  void saturate(std::size_t size, std::uint64_t backlog) {
    at(now(), [this, size, backlog] { refill(size, backlog); });
  }
  void refill(std::size_t size, std::uint64_t backlog) {
    while (saturated && queued() < backlog && send(0, size) == core::Outcome::kDelivered) {
    }
    if (saturated) at(now() + 2ms, [this, size, backlog] { refill(size, backlog); });
  }
  // Sends small messages of the highest class from time to time.
  void ping(Duration every) {
    send(255, 64 - kHeaderSize);
    at(now() + every, [this, every] { ping(every); });
  }
  // Bytes per second that arrive at the sink.
  double goodput(Duration settle, Duration span) {
    run_for(settle);
    const std::uint64_t before = bytes;
    run_for(span);
    return static_cast<double>(bytes - before) / duration<double>(span).count();
  }
  [[nodiscard]] Duration delay(double part) {
    if (delays.empty()) return Duration::max();
    std::ranges::sort(delays);
    return delays[static_cast<std::size_t>(static_cast<double>(delays.size() - 1) * part)];
  }

  static constexpr Address kSink{0x00020000};
  static constexpr Address kSource{0x01140000};
  static constexpr std::uint8_t kUrgent = 224;
  Node* base;
  Node* robot;
  core::ClientId sink{};
  core::ClientId source{};
  bool saturated = true;
  std::uint64_t bytes = 0;
  std::uint64_t messages = 0;
  std::vector<Duration> delays;
};

double ms(Duration d) { return duration<double, std::milli>(d).count(); }

void report(const char* what, double share, Line& line) {
  std::printf("%-34s %5.2f of the rate; urgent p50 %.2f ms, p99 %.2f ms, max %.2f ms\n", what,
              share, ms(line.delay(0.5)), ms(line.delay(0.99)), ms(line.delay(1)));
}

TEST(Rate, TenPercentLossCostsLittle) {
  Line line({.loss = 0.1, .delay = 10ms, .rate = 50 * kMbit, .queue = 312'500});
  line.saturate(20'000, 4 << 20);
  line.ping(10ms);
  const double share = line.goodput(3s, 5s) / (50 * kMbit);
  report("10 % loss, 20 ms, 50 Mbit/s", share, line);
  EXPECT_GE(share, 0.7);
  EXPECT_LT(line.delay(0.99), 80ms);
}

TEST(Rate, UrgentMessagesPassASaturatedLink) {
  Line line({.delay = 100us, .rate = 50 * kMbit, .queue = 312'500});
  line.saturate(1 << 20, 8 << 20);
  line.ping(5ms);
  const double share = line.goodput(2s, 8s) / (50 * kMbit);
  report("0.2 ms, 50 Mbit/s, 50 ms buffer", share, line);
  EXPECT_GE(share, 0.8);
  EXPECT_LE(line.delay(0.99), 5ms);
}

// The window is full, and the first acknowledgement is 50 ms away.
TEST(Rate, UrgentMessagesGoBeyondTheWindow) {
  Line line({.delay = 100ms});
  line.send(0, 1 << 20);
  line.run_for(150ms);
  line.send(255, 64);
  line.run_for(1s);
  EXPECT_LT(line.delay(1), 102ms);
}

TEST(Rate, AfterAPauseItStartsSlowly) {
  Line line({.delay = 5ms, .rate = 50 * kMbit, .queue = 312'500});
  const auto window = [&] { return line.robot->links().uplink()->session().congestion().window(); };
  line.saturate(20'000, 4 << 20);
  line.run_for(3s);
  EXPECT_GT(window(), 20'000U);
  line.cut("robot", "base");
  line.run_for(600ms);  // shorter than the timeout of the link
  ASSERT_NE(line.robot->links().uplink(), nullptr);
  EXPECT_LT(window(), 10'000U);
}

TEST(Rate, AConfiguredRateKeepsUrgentMessagesNearlyUndisturbed) {
  Line line({.delay = 100us, .rate = 50 * kMbit, .queue = 312'500}, {.rate = 50 * kMbit});
  line.ping(5ms);
  line.run_for(1s);
  const Duration unloaded = line.delay(0.99);
  line.delays.clear();
  line.saturate(1 << 20, 8 << 20);
  const double share = line.goodput(2s, 8s) / (50 * kMbit);
  report("the same with its rate configured", share, line);
  EXPECT_GE(share, 0.8);
  EXPECT_LE(line.delay(0.99), unloaded + 500us);
}

// The network has no limit; only the configured rate limits the link.
TEST(Rate, AConfiguredRateIsNotExceeded) {
  Line line({.delay = 1ms}, {.rate = 8 * kMbit});
  line.saturate(20'000, 4 << 20);
  line.run_for(1s);
  const std::uint64_t before = line.bytes_sent("robot");
  line.run_for(5s);
  const double share = static_cast<double>(line.bytes_sent("robot") - before) / (40 * kMbit);
  EXPECT_LE(share, 0.91) << "a tenth is for the upper classes";
  EXPECT_GE(share, 0.85);
}

TEST(Rate, TheLowerClassesLeaveAReserve) {
  Line line({.delay = 1ms}, {.rate = 8 * kMbit, .reserve = 50});
  line.saturate(20'000, 4 << 20);
  const double lower = line.goodput(1s, 5s) / (8 * kMbit);
  EXPECT_LE(lower, 0.5);
  EXPECT_GE(lower, 0.4);
  line.saturated = false;
  for (int i = 0; i < 200; ++i) line.send(128, 20'000);
  const double both = line.goodput(0s, 3s) / (8 * kMbit);
  EXPECT_GE(both, 0.8);
  EXPECT_LE(both, 1.0);
}

TEST(Rate, WiFiJitterCostsLittle) {
  Line line({.loss = 0.01, .delay = 1ms, .jitter = 10ms, .rate = 50 * kMbit, .queue = 312'500});
  line.saturate(100'000, 8 << 20);
  line.ping(10ms);
  const double share = line.goodput(3s, 5s) / (50 * kMbit);
  report("1 % loss, +-5 ms, 50 Mbit/s", share, line);
  EXPECT_GE(share, 0.6);
}

// Streams of samples over a line. Each sample contains the time at which it was sent, so its age at
// arrival is known.
struct Streams : Line {
  explicit Streams(const Faults& faults) : Line(faults) {
    base->on_arrival = [this](Node&, core::ClientId, Arrival&& arrival) {
      std::int64_t sent = 0;
      std::memcpy(&sent, arrival.body.data(), sizeof(sent));
      const Duration age = arrival.at.time_since_epoch() - Duration(sent);
      ages.at(static_cast<std::size_t>(arrival.header.type)).push_back(age);
      bytes += arrival.header.length;
    };
  }
  void sample(std::int8_t type, std::uint8_t priority, std::size_t size) {
    std::vector<std::byte> body(size);
    const std::int64_t at = now().time_since_epoch().count();
    std::memcpy(body.data(), &at, sizeof(at));
    (void)robot->send(now(), source,
                      {.flags = flag::kNativeOrder | flag::kStream,
                       .type = type,
                       .priority = priority,
                       .dest = kSink,
                       .src = kSource},
                      body);
  }
  // Each camera sends 20 pictures of 1 MiB per second.
  void run(int seconds, std::int8_t cameras, std::size_t scan) {
    for (int i = 0; i < seconds * 20; ++i) {
      for (std::int8_t camera = 0; camera < cameras; ++camera) sample(camera, kCamera, 1 << 20);
      if (scan > 0) sample(2, kLaser, scan);
      run_for(50ms);
    }
  }
  static constexpr std::uint8_t kCamera = 20;  // as robots do
  static constexpr std::uint8_t kLaser = 30;
  std::array<std::vector<Duration>, 3> ages;
};

// Two cameras and a scanner on a line with the capacity of three pictures per second: the newest
// pictures of both cameras arrive alternately, with the scans between them.
TEST(Rate, PicturesOfStreamsCrossALossyLine) {
  Streams line({.loss = 0.02, .delay = 5ms, .rate = 20 * kMbit, .queue = 312'500});
  constexpr int kSeconds = 20;
  line.run(kSeconds, 2, 3'668);
  for (const std::size_t camera : {0U, 1U}) {
    ASSERT_GE(line.ages.at(camera).size(), kSeconds)
        << camera;  // the line carries 2.4 per second of both cameras together
    EXPECT_LE(*std::ranges::max_element(line.ages.at(camera)), 2500ms) << camera;
  }
  EXPECT_GE(line.ages[2].size(), kSeconds * 10U) << "scans";
}

// The share of a lossy line that a camera can use.
TEST(Rate, LossCostsAStreamOfPicturesLittle) {
  for (const double loss : {0.0, 0.01, 0.02, 0.05}) {
    Streams line({.loss = loss, .delay = 5ms, .rate = 20 * kMbit, .queue = 312'500});
    line.run(3, 1, 0);
    const std::uint64_t before = line.bytes;
    const std::uint64_t wire = line.bytes_sent("robot");
    line.run(20, 1, 0);
    const double share = static_cast<double>(line.bytes - before) / (400 * kMbit);
    const double sent = static_cast<double>(line.bytes_sent("robot") - wire) / (400 * kMbit);
    const auto& ages = line.ages[0];
    std::printf("pictures of 1 MiB, %.0f %% loss: %.2f of the rate, of %.2f that were sent",
                loss * 100, share, sent);
    if (!ages.empty()) std::printf("; oldest %.0f ms", ms(*std::ranges::max_element(ages)));
    std::printf("\n");
    EXPECT_GE(share, 0.7) << loss;
    EXPECT_LE(sent * (1 - loss), 1.0) << loss;
  }
}

TEST(Rate, ASlowMobileNetwork) {
  Line line({.delay = 40ms, .jitter = 5ms, .rate = 100'000, .queue = 64 << 10});
  line.saturate(50'000, 1 << 20);
  line.ping(100ms);
  const double share = line.goodput(5s, 20s) / 100'000;
  report("80 ms, 100 kB/s", share, line);
  EXPECT_GE(share, 0.7);
}

TEST(Rate, AFastLink) {
  Line line({.delay = 50us, .rate = 1'000'000'000, .queue = 4 << 20});
  line.saturate(1 << 20, 12 << 20);
  line.ping(5ms);
  const double share = line.goodput(300ms, 300ms) / 1e9;
  report("0.1 ms, 1 GB/s", share, line);
  EXPECT_GE(share, 0.8);
}

// Two robots whose links share one radio.
TEST(Rate, TwoLinksShareABottleneck) {
  SimulatedNetwork network(7);
  Node& base = network.add({.name = "base", .role = core::Role::kTop, .links = {sub_link()}});
  std::array<Node*, 2> robots{};
  std::array<core::ClientId, 2> clients{};
  std::array<std::uint64_t, 2> bytes{};
  const auto mailbox = [](std::size_t i) {
    return Address::of({.system = static_cast<std::uint32_t>(i + 1), .class_id = 0x14});
  };
  network.set_faults({.delay = 5ms, .rate = 50 * kMbit, .queue = 312'500});
  base.start(network.now());
  for (std::size_t i = 0; i < 2; ++i) {
    robots[i] = &network.add({.name = "robot" + std::to_string(i),
                              .system = static_cast<std::uint8_t>(i + 1),
                              .links = {super_link(address_of(0))}});
    robots[i]->start(network.now());
    clients[i] = robots[i]->add_client(network.now(), "source");
    robots[i]->add_mailbox(network.now(), clients[i], mailbox(i));
  }
  network.share("robot0", "base", "robot1", "base");
  const auto sink = base.add_client(network.now(), "sink");
  base.add_mailbox(network.now(), sink, Line::kSink);
  base.on_arrival = [&](Node&, core::ClientId, Arrival&& arrival) {
    bytes[arrival.header.src == mailbox(0) ? 0 : 1] += arrival.header.length;
  };
  network.run_for(1s);
  const std::vector<std::byte> body(50'000);
  std::function<void(std::size_t)> refill = [&](std::size_t i) {
    std::uint64_t queued = 0;
    robots[i]->links().for_each([&](const link::Link& l) { queued = l.session().queued_bytes(); });
    for (; queued < 2'000'000; queued += body.size())
      robots[i]->send(network.now(), clients[i],
                      {.type = -7, .dest = Line::kSink, .src = mailbox(i)}, body);
    network.at(network.now() + 5ms, [&, i] { refill(i); });
  };
  refill(0);
  network.run_for(3s);  // the second robot starts late
  refill(1);
  network.run_for(5s);
  bytes = {};
  network.run_for(10s);
  const double share = static_cast<double>(bytes[0]) / static_cast<double>(bytes[1]);
  const double all = static_cast<double>(bytes[0] + bytes[1]) / 10 / (50 * kMbit);
  std::printf("two links share a bottleneck: first/second %.2f, together %.2f of the rate\n", share,
              all);
  EXPECT_GE(share, 0.5);
  EXPECT_LE(share, 2.0);
  EXPECT_GE(all, 0.8);
}

}  // namespace rate_test
}  // namespace tims::sim

// A flood of forged datagrams costs no memory, and little time however many links there are. A
// program of its own, because it counts every `new`.
#include <chrono>
#include <memory>

#include <gtest/gtest.h>

#include "router/link/links.h"
#include "tests/support/counted_new.h"

namespace tims::link {
namespace flood_test {

using namespace std::chrono_literals;

constexpr std::uint32_t kLinks = 1000;
constexpr std::uint64_t kForged = 100'000;

struct NoHooks final : core::RouterHooks {
  void admin(Time, core::ClientId, const core::Message&) override {}
  void traced(core::ClientId, core::ClientId, const core::Message&) override {}
  void event(const core::Event&) override { ++events; }
  std::size_t events = 0;
};

struct CountingSender final : DatagramSender {
  bool offer(const Burst& burst) override {
    bytes += burst.bytes.size();
    last.assign(burst.bytes.begin(), burst.bytes.end());
    return true;
  }
  std::size_t bytes = 0;
  std::vector<std::byte> last;
};

class Flood : public testing::Test {
 protected:
  Flood() : blocks_(1U << 20), parts_(64U << 20) {
    router_.attach(core::PortKind::kLink, links_);
    links_.set_sender(PathKind::kUdp, &sender_);
    const LinkSettings sub{.kind = LinkKind::kSub, .connects = false};
    links_.configure(now_, {&sub, 1});
    for (std::uint32_t n = 0; n < kLinks; ++n) connect(n);
  }

  static Hello hello_of(std::uint64_t n, std::uint16_t system, std::uint16_t id) {
    return {.kind = LinkKind::kSuper,
            .token = n + 1,
            .keep_alive = 300ms,
            .identity = {.epoch = n + 7, .role = Role::kSystem, .system = system, .id = id}};
  }
  static NetAddress address_of(std::uint64_t n) {
    return NetAddress::v4(10, static_cast<std::uint8_t>(n >> 16), static_cast<std::uint8_t>(n >> 8),
                          static_cast<std::uint8_t>(n), 2010);
  }
  void give(const NetAddress& from, const auto& datagram) {
    std::array<std::byte, kControlDatagramMax> bytes{};
    links_.on_datagram(now_, from, std::span(bytes).first(encode(datagram, bytes)));
    links_.flush(now_);
  }
  void connect(std::uint32_t n) {
    now_ += 1ms;
    Hello hello = hello_of(n, static_cast<std::uint16_t>(1 + n / 200),
                           static_cast<std::uint16_t>(1 + n % 200));
    give(address_of(n), hello);
    const auto retry = decode(sender_.last);
    hello.cookie = std::get<Retry>(*retry).cookie;
    give(address_of(n), hello);
  }

  Time now_{100s};
  NoHooks hooks_;
  CountingSender sender_;
  std::vector<std::byte> blocks_;
  std::vector<std::byte> parts_;
  core::Router router_{
      {.address = Address(1), .role = Role::kTop, .clients_max = 8192}, {1, 2}, hooks_};
  core::BlockPool pool_{blocks_};
  MessageMemory memory_{parts_, 1U << 20, 64U << 20};
  Links links_{router_, pool_, memory_, {.self = {.epoch = 1, .role = Role::kTop, .id = 1}}};
};

TEST_F(Flood, OfHellosUsesNoMemoryAndLittleTime) {
  std::uint32_t up = 0;
  links_.for_each([&](const Link& link) { up += link.is_up() ? 1U : 0U; });
  ASSERT_EQ(up, kLinks);
  give(address_of(0), hello_of(0, 3, 4));
  now_ += 1s;
  const std::size_t events = hooks_.events;
  sender_.bytes = 0;
  const std::size_t before = test::allocations();
  const auto began = std::chrono::steady_clock::now();
  for (std::uint64_t n = 0; n < kForged; ++n)
    give(address_of(n), hello_of(n + kForged, static_cast<std::uint16_t>(n % 250),
                                 static_cast<std::uint16_t>(n % 200)));
  const std::chrono::duration<double, std::micro> each =
      (std::chrono::steady_clock::now() - began) / static_cast<double>(kForged);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(hooks_.events, events);
  EXPECT_EQ(sender_.bytes, 24 * Reception::kRetriesAtOnce) << "RETRYs, as many as are sent";
  RecordProperty("microseconds_each", std::to_string(each.count()));
  // 100 000 a second must leave the processor to others. Loose, for busy machines: it takes 0.3 us.
  EXPECT_LT(each.count(), 5);
}

TEST_F(Flood, OfOtherDatagramsUsesNoMemory) {
  give(address_of(0), Reset{1});
  const std::size_t events = hooks_.events;
  const std::size_t before = test::allocations();
  sender_.bytes = 0;
  std::array<std::byte, kDataHeaderSize + kNonceFrameSize> data{};
  for (std::uint64_t n = 0; n < kForged / 10; ++n) {
    const NetAddress from = address_of(n);
    give(from, Reset{n + kForged});
    give(from, Retry{n + kForged, n});
    give(from, Welcome{.echo = n + kForged, .token = n + 1, .identity = {.epoch = n + 1}});
    give(from, Refuse{.echo = n + kForged});
    encode({.token = n + kForged, .packet = 5}, std::span(data).first<kDataHeaderSize>());
    links_.on_datagram(now_, from, data);
    links_.flush(now_);
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(hooks_.events, events);
  EXPECT_EQ(sender_.bytes, 16 * Links::kResetsAtOnce) << "a RESET for DATA, as many as are sent";
}

TEST_F(Flood, OfHellosLeavesAnswersForOthersInTheNextMoment) {
  for (std::uint64_t n = 0; n < kForged; ++n) give(address_of(n), SealedHello{n + kForged});
  sender_.bytes = 0;
  give(address_of(1), SealedHello{1});
  EXPECT_EQ(sender_.bytes, 0U);
  now_ += Duration(1s) / static_cast<Duration::rep>(Reception::kRetriesPerSecond);
  give(address_of(1), SealedHello{1});
  EXPECT_EQ(sender_.bytes, 24U);
}

// One address that is proven, and one cookie: each datagram begins as if its sender began again.
TEST_F(Flood, OfHandshakesWithOneCookieGivesTheHandshakerOneOfThem) {
  struct BusyHandshaker final : Handshaker {
    void begin(std::uint64_t, Side, std::span<const std::byte>) override { ++calls; }
    void receive(std::uint64_t, std::span<const std::byte>) override { ++calls; }
    void send(std::uint64_t, std::span<const std::byte>) override { ++calls; }
    void end(std::uint64_t) override { ++calls; }
    std::size_t calls = 0;
  };
  BusyHandshaker busy;
  Links sealed(router_, pool_, memory_,
               {.self = {.epoch = 1, .role = Role::kTop, .id = 1}, .handshaker = &busy});
  sealed.set_sender(PathKind::kUdp, &sender_);
  std::array<std::byte, kControlDatagramMax> bytes{};
  const auto give_sealed = [&](const auto& datagram) {
    sealed.on_datagram(now_, address_of(0), std::span(bytes).first(encode(datagram, bytes)));
    sealed.flush(now_);
  };
  give_sealed(SealedHello{5});
  const auto retry = decode(sender_.last);
  std::array<std::byte, 1> first{};
  const Crypto crypto{.token = 5, .cookie = std::get<Retry>(*retry).cookie, .bytes = first};
  give_sealed(crypto);
  const std::size_t before = test::allocations();
  for (std::uint64_t n = 1; n <= kForged; ++n) {
    first[0] = static_cast<std::byte>(1 + n % 255);
    give_sealed(crypto);
  }
  EXPECT_EQ(busy.calls, 2U) << "begin and receive";
  EXPECT_EQ(test::allocations(), before);
}

// Of a version nobody knows: a REFUSE is the longest answer, and there are few of them.
TEST_F(Flood, OfUnknownVersionsIsRefusedAFewTimes) {
  sender_.bytes = 0;
  for (std::uint64_t n = 0; n < 1000; ++n) {
    Hello hello = hello_of(n, 1, 1);
    hello.version_min = hello.version_max = 200;
    give(address_of(n), hello);
  }
  EXPECT_LE(sender_.bytes, 20 * kHelloSize);
  EXPECT_GT(sender_.bytes, 0U);
}

}  // namespace flood_test
}  // namespace tims::link

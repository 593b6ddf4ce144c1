// Requirements of a path below the links, over UDP, DDS and TCP: bursts of datagrams are sent in
// one call and arrive complete, from the address at which their sender receives; no call blocks.
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "router/io/net/udp_socket.h"
#include "router/io/tcp_path_fixture.h"
#include "tests/support/dds_fixture.h"
#include "tests/support/eventually.h"

namespace tims::io {
namespace path_contract_test {

enum class Kind : std::uint8_t { kUdp, kDds, kTcp };

// One router's end of a path.
class End {
 public:
  using Arrival = Host::Arrival;

  End() = default;
  End(const End&) = delete;
  End& operator=(const End&) = delete;
  virtual ~End() = default;

  [[nodiscard]] virtual link::NetAddress address() const = 0;
  // Whether datagrams of this end come from there.
  [[nodiscard]] virtual bool sends_from(const link::NetAddress& from) const {
    return from == address();
  }
  // Whether this end knows that it can send to the other.
  [[nodiscard]] virtual bool knows(const End& other) const = 0;
  virtual bool send(const link::Burst& burst) = 0;
  virtual void take_what_came() = 0;
  [[nodiscard]] const std::vector<Arrival>& arrivals() const { return arrivals_; }

 protected:
  std::vector<Arrival> arrivals_{};
};

class UdpEnd final : public End {
 public:
  UdpEnd() : socket_(UdpSocket::open({"127.0.0.1", 0}).value()) {}
  link::NetAddress address() const override { return socket_.local(); }
  bool knows(const End&) const override { return true; }
  bool send(const link::Burst& burst) override { return socket_.send(burst) == Sent::kAll; }
  void take_what_came() override {
    while (socket_.receive(datagrams_))
      datagrams_.for_each_datagram([&](const link::NetAddress& from, std::span<std::byte> bytes) {
        arrivals_.push_back({from, {bytes.begin(), bytes.end()}});
      });
  }

 private:
  UdpSocket socket_;
  Datagrams datagrams_;
};

class DdsEnd final : public End {
 public:
  explicit DdsEnd(const std::string& name) : host_(loop_, name) {
    EXPECT_TRUE(host_.start());
    EXPECT_TRUE(run_until(
        loop_, [&] { return host_.is_up(); }, "up"));
  }
  link::NetAddress address() const override { return host_.address(); }
  bool knows(const End& other) const override {
    return host_.sees(dynamic_cast<const DdsEnd&>(other).host_);
  }
  bool send(const link::Burst& burst) override { return host_.engine.send(burst); }
  void take_what_came() override {
    loop_.run_once(os::now() + std::chrono::milliseconds(1));
    arrivals_ = host_.arrivals;
  }

 private:
  Loop loop_;
  Host host_;
};

class TcpEnd final : public End {
 public:
  link::NetAddress address() const override { return host_.address; }
  // The system chooses the port of a connection.
  bool sends_from(const link::NetAddress& from) const override {
    return from.kind == link::PathKind::kTcp && from.ip == host_.address.ip;
  }
  bool knows(const End&) const override { return true; }
  bool send(const link::Burst& burst) override { return host_.send(burst); }
  void take_what_came() override {
    loop_.run_once(os::now() + std::chrono::milliseconds(1));
    for (TcpHost::Arrival& arrival : host_.arrivals)
      arrivals_.push_back({arrival.from, std::move(arrival.bytes)});
    host_.arrivals.clear();
  }

 private:
  Loop loop_;
  TcpHost host_{loop_};
};

class PathContract : public testing::TestWithParam<Kind> {
 protected:
  std::unique_ptr<End> end(const std::string& name) {
    if (GetParam() == Kind::kUdp) return std::make_unique<UdpEnd>();
    if (GetParam() == Kind::kTcp) return std::make_unique<TcpEnd>();
    return std::make_unique<DdsEnd>(name);
  }
  static testing::AssertionResult meet(End& a, End& b) {
    return test::eventually(
        [&] {
          a.take_what_came();
          b.take_what_came();
          return a.knows(b) && b.knows(a);
        },
        "each knows the other");
  }
  // Runs both ends, because `sender` may have to act as well.
  static testing::AssertionResult comes(End& sender, End& to, std::size_t count) {
    return test::eventually([&]() -> std::string {
      sender.take_what_came();
      to.take_what_came();
      return to.arrivals().size() >= count ? "" : std::to_string(to.arrivals().size()) + " came";
    });
  }
};

// A different pattern for each datagram of a burst.
Bytes pattern(std::size_t size, std::size_t datagram_size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i)
    bytes[i] = static_cast<std::byte>(i / datagram_size * 7 + i % datagram_size);
  return bytes;
}

TEST_P(PathContract, BurstsOfAnySizeArriveCompleteInOrderWithTheirSender) {
  const auto a = end("a");
  const auto b = end("b");
  ASSERT_TRUE(meet(*a, *b));
  std::size_t before = 0;
  for (const auto& [bytes, datagram_size] :
       std::vector<std::pair<std::size_t, std::size_t>>{{1, 1},
                                                        {100, 100},
                                                        {1200, 1200},
                                                        {8972, 8972},
                                                        {40 * 1200 + 300, 1200},
                                                        {link::kBurstDatagramsMax * 40, 40},
                                                        {link::kBurstBytesMax, 8972}}) {
    const Bytes burst = pattern(bytes, datagram_size);
    ASSERT_TRUE(a->send({.to = b->address(), .bytes = burst, .datagram_size = datagram_size}));
    const std::size_t count = (bytes + datagram_size - 1) / datagram_size;
    ASSERT_TRUE(comes(*a, *b, before + count)) << bytes << " by " << datagram_size;
    ASSERT_EQ(b->arrivals().size(), before + count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto part = std::span(burst).subspan(i * datagram_size);
      const auto expected = part.first(std::min(datagram_size, part.size()));
      const End::Arrival& arrival = b->arrivals()[before + i];
      EXPECT_TRUE(std::ranges::equal(arrival.bytes, expected)) << i << " of " << bytes;
      EXPECT_TRUE(a->sends_from(arrival.from));
    }
    before += count;
  }
}

TEST_P(PathContract, AnAnswerGoesToTheSendersAddress) {
  const auto a = end("a");
  const auto b = end("b");
  ASSERT_TRUE(meet(*a, *b));
  const Bytes question = pattern(20, 20);
  ASSERT_TRUE(a->send({.to = b->address(), .bytes = question, .datagram_size = 20}));
  ASSERT_TRUE(comes(*a, *b, 1));
  ASSERT_TRUE(b->send({.to = b->arrivals()[0].from, .bytes = question, .datagram_size = 20}));
  EXPECT_TRUE(comes(*b, *a, 1));
}

// Datagrams that it does not read in time are lost or refused; those of another router are not.
TEST_P(PathContract, ARouterThatDoesNotReadDoesNotBlockOthers) {
  const auto a = end("a");
  const auto b = end("b");
  const auto unresponsive = end("unresponsive");
  ASSERT_TRUE(meet(*a, *b));
  ASSERT_TRUE(meet(*a, *unresponsive));
  const Bytes flood = pattern(60'000, 1200);
  const Bytes message = pattern(50, 50);
  for (std::size_t i = 0; i < 500; ++i)  // 30 MB: more than any buffer
    (void)a->send({.to = unresponsive->address(), .bytes = flood, .datagram_size = 1200});
  for (std::size_t i = 0; i < 20; ++i) {
    (void)a->send({.to = unresponsive->address(), .bytes = flood, .datagram_size = 1200});
    ASSERT_TRUE(a->send({.to = b->address(), .bytes = message, .datagram_size = 50}));
    ASSERT_TRUE(comes(*a, *b, i + 1)) << i;
  }
}

TEST_P(PathContract, SendingToAClosedRouterIsNoErrorAndItsSuccessorIsReached) {
  const auto a = end("a");
  const Bytes message = pattern(50, 50);
  for (int round = 0; round < 2; ++round) {
    auto b = end("b");
    ASSERT_TRUE(meet(*a, *b));
    const link::NetAddress was = b->address();
    ASSERT_TRUE(a->send({.to = was, .bytes = message, .datagram_size = 50}));
    ASSERT_TRUE(comes(*a, *b, 1));
    b.reset();
    for (int i = 0; i < 100; ++i) (void)a->send({.to = was, .bytes = message, .datagram_size = 50});
  }
}

constexpr std::array kKinds {
  Kind::kUdp, Kind::kTcp,
#if TIMS_WITH_DDS
      Kind::kDds,
#endif
};
INSTANTIATE_TEST_SUITE_P(Paths, PathContract, testing::ValuesIn(kKinds),
                         [](const testing::TestParamInfo<Kind>& kind) {
                           return kind.param == Kind::kUdp   ? "Udp"
                                  : kind.param == Kind::kDds ? "Dds"
                                                             : "Tcp";
                         });

}  // namespace path_contract_test
}  // namespace tims::io

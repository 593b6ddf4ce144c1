#include "router/io/net/udp_socket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/udp.h>
#include <poll.h>

#include "os/service_manager.h"
#include "router/io/net/addresses.h"
#include "tests/support/own_network.h"
#include "tests/support/patience.h"

namespace tims::io {
namespace udp_socket_test {

using link::Burst;
using link::NetAddress;

struct Arrival {
  NetAddress from{};
  std::vector<std::byte> bytes{};
};

UdpSocket open(const std::string& host, const UdpOptions& options = {}) {
  auto socket = UdpSocket::open({host, 0}, options);
  EXPECT_TRUE(socket) << socket.error().message();
  return std::move(socket).value();
}

// Until `count` datagrams have come.
std::vector<Arrival> receive(UdpSocket& socket, std::size_t count, Datagrams& datagrams) {
  std::vector<Arrival> arrivals;
  while (arrivals.size() < count) {
    pollfd readable{socket.fd(), POLLIN, 0};
    if (::poll(&readable, 1, test::kPatienceMs) != 1) break;
    EXPECT_TRUE(socket.receive(datagrams));
    datagrams.for_each_datagram([&](const NetAddress& from, std::span<std::byte> bytes) {
      arrivals.push_back({from, {bytes.begin(), bytes.end()}});
    });
  }
  EXPECT_EQ(arrivals.size(), count);
  return arrivals;
}

std::vector<Arrival> receive(UdpSocket& socket, std::size_t count) {
  Datagrams datagrams;
  return receive(socket, count, datagrams);
}

// Each datagram of a burst looks different.
std::vector<std::byte> pattern(std::size_t size, std::size_t datagram_size) {
  std::vector<std::byte> bytes(size);
  for (std::size_t i = 0; i < size; ++i)
    bytes[i] = static_cast<std::byte>(i / datagram_size * 7 + i % datagram_size);
  return bytes;
}

std::vector<std::byte> part(const std::vector<std::byte>& bytes, std::size_t at, std::size_t size) {
  const auto rest = std::span(bytes).subspan(at);
  const auto cut = rest.first(std::min(size, rest.size()));
  return {cut.begin(), cut.end()};
}

void expect_burst(const std::vector<Arrival>& arrivals, const std::vector<std::byte>& bytes,
                  std::size_t datagram_size, const NetAddress& from) {
  for (std::size_t i = 0; i < arrivals.size(); ++i) {
    EXPECT_EQ(arrivals[i].from, from) << arrivals[i].from.to_string();
    EXPECT_EQ(arrivals[i].bytes, part(bytes, i * datagram_size, datagram_size)) << "number " << i;
  }
}

NetAddress v4_loopback(std::uint16_t port) { return NetAddress::v4(127, 0, 0, 1, port); }

NetAddress v6_loopback(std::uint16_t port) {
  NetAddress address{.port = port};
  address.ip[15] = 1;
  return address;
}

// --- What arrives

class UdpFamily : public testing::TestWithParam<const char*> {};

TEST_P(UdpFamily, OneDatagram) {
  UdpSocket a = open(GetParam());
  UdpSocket b = open(GetParam());
  const auto bytes = pattern(100, 100);
  ASSERT_EQ(a.send({.to = b.local(), .bytes = bytes, .datagram_size = 100}), Sent::kAll);
  expect_burst(receive(b, 1), bytes, 100, a.local());
}

TEST_P(UdpFamily, BurstArrivesInOrder) {
  UdpSocket a = open(GetParam());
  UdpSocket b = open(GetParam());
  const auto bytes = pattern(40 * 1200 + 300, 1200);
  const Burst burst{.to = b.local(), .bytes = bytes, .datagram_size = 1200, .dscp = 46};
  ASSERT_EQ(a.send(burst), Sent::kAll);
  const auto arrivals = receive(b, 41);
  expect_burst(arrivals, bytes, 1200, a.local());
  EXPECT_EQ(arrivals.back().bytes.size(), 300);
}

TEST_P(UdpFamily, BurstWithoutSegmentation) {
  UdpSocket a = open(GetParam(), {.segmentation = false});
  UdpSocket b = open(GetParam());
  const auto bytes = pattern(40 * 1200 + 300, 1200);
  const Burst burst{.to = b.local(), .bytes = bytes, .datagram_size = 1200, .dscp = 46};
  ASSERT_EQ(a.send(burst), Sent::kAll);
  expect_burst(receive(b, 41), bytes, 1200, a.local());
  EXPECT_EQ(a.counters().cut_short, 0);
}

INSTANTIATE_TEST_SUITE_P(Loopback, UdpFamily, testing::Values("127.0.0.1", "::1"),
                         [](const auto& family) { return family.param[0] == ':' ? "v6" : "v4"; });

// A socket without checksums is one that the kernel refuses to cut bursts for.
TEST(UdpSocket, BurstThatTheKernelRefusesToCut) {
  UdpSocket a = open("127.0.0.1");
  UdpSocket b = open("127.0.0.1");
  const int yes = 1;
  ASSERT_EQ(::setsockopt(a.fd(), SOL_SOCKET, SO_NO_CHECK, &yes, sizeof yes), 0);
  const auto bytes = pattern(3000, 1000);
  const Burst burst{.to = b.local(), .bytes = bytes, .datagram_size = 1000};
  for (int i = 0; i < 2; ++i) {
    ASSERT_EQ(a.send(burst), Sent::kAll);
    expect_burst(receive(b, 3), bytes, 1000, a.local());
  }
}

TEST(UdpSocket, DualStackReceivesAndAnswersBoth) {
  UdpSocket dual = open("::");
  UdpSocket v4 = open("127.0.0.1");
  UdpSocket v6 = open("::1");
  const auto bytes = pattern(3000, 1000);
  const std::uint16_t port = dual.local().port;
  ASSERT_EQ(v4.send({v4_loopback(port), bytes, 1000, 46}), Sent::kAll);
  expect_burst(receive(dual, 3), bytes, 1000, v4.local());
  ASSERT_EQ(v6.send({v6_loopback(port), bytes, 1000, 46}), Sent::kAll);
  expect_burst(receive(dual, 3), bytes, 1000, v6.local());

  ASSERT_EQ(dual.send({v4.local(), bytes, 1000, 46}), Sent::kAll);
  expect_burst(receive(v4, 3), bytes, 1000, v4_loopback(port));
  ASSERT_EQ(dual.send({v6.local(), bytes, 1000, 46}), Sent::kAll);
  expect_burst(receive(v6, 3), bytes, 1000, v6_loopback(port));
}

TEST(UdpSocket, EmptyDatagramArrives) {
  UdpSocket a = open("127.0.0.1");
  UdpSocket b = open("127.0.0.1");
  ASSERT_EQ(a.send({.to = b.local()}), Sent::kAll);
  EXPECT_EQ(receive(b, 1)[0].bytes.size(), 0);
}

TEST(UdpSocket, ReceivesNothingWithoutWaiting) {
  UdpSocket a = open("127.0.0.1");
  Datagrams datagrams;
  EXPECT_FALSE(a.receive(datagrams));
  EXPECT_TRUE(datagrams.slots().empty());
}

TEST(UdpSocket, DatagramsLargerThanASlotAreLeftOut) {
  UdpSocket a = open("127.0.0.1");
  UdpSocket b = open("127.0.0.1");
  const auto bytes = pattern(200, 200);
  ASSERT_EQ(a.send({b.local(), bytes, 200}), Sent::kAll);
  ASSERT_EQ(a.send({b.local(), std::span(bytes).first(100), 100}), Sent::kAll);
  Datagrams small(128);
  EXPECT_EQ(receive(b, 1, small)[0].bytes, part(bytes, 0, 100));
  EXPECT_EQ(b.counters().truncated, 1);
}

TEST(UdpSocket, CountsWhatTheKernelDropped) {
  UdpSocket a = open("127.0.0.1");
  UdpSocket b = open("127.0.0.1", {.buffer_bytes = 4096});
  const auto bytes = pattern(1000, 1000);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(a.send({b.local(), bytes, 1000}), Sent::kAll);
  Datagrams datagrams;
  std::size_t arrived = 0;
  const auto count = [&](const NetAddress&, std::span<std::byte>) { ++arrived; };
  while (b.receive(datagrams)) datagrams.for_each_datagram(count);
  ASSERT_LT(arrived, 100);
  ASSERT_EQ(a.send({b.local(), bytes, 1000}), Sent::kAll);  // carries the number
  receive(b, 1, datagrams);
  EXPECT_EQ(arrived + b.counters().dropped_by_kernel, 100);
}

// --- reports of the socket

TEST(UdpSocket, ReportsTheGrantedBuffers) {
  const UdpSocket socket = open("127.0.0.1", {.buffer_bytes = 100'000});
  EXPECT_EQ(socket.asked_buffer_bytes(), 100'000);
  EXPECT_EQ(socket.receive_buffer_bytes(), 100'000);
  EXPECT_EQ(socket.send_buffer_bytes(), 100'000);
  EXPECT_EQ(open("::").asked_buffer_bytes(), 8U << 20);
}

TEST(UdpSocket, APortInUseIsReported) {
  const UdpSocket first = open("127.0.0.1");
  const auto second = UdpSocket::open({"127.0.0.1", first.local().port});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code(), Errc::kAddressInUse);
  EXPECT_THAT(second.error().detail(),
              testing::HasSubstr("127.0.0.1:" + std::to_string(first.local().port)));
}

// As after a restart of the router: what has arrived meanwhile waits there.
TEST(UdpSocket, ASocketOfTheStoreIsUsedWithWhatWaitsInIt) {
  UdpSocket sender = open("127.0.0.1");
  const UdpSocket former = open("127.0.0.1");
  const std::uint16_t port = former.local().port;
  const auto bytes = pattern(100, 100);
  ASSERT_EQ(sender.send({.to = former.local(), .bytes = bytes, .datagram_size = 100}), Sent::kAll);

  os::ServiceManager nobody{std::string()};
  std::vector<os::File> inherited;
  inherited.emplace_back(::dup(former.fd()));
  os::SocketStore store(nobody, {.sockets = std::move(inherited)});
  auto socket = UdpSocket::open({"127.0.0.1", port}, {}, &store);
  ASSERT_TRUE(socket) << socket.error().message();
  EXPECT_EQ(socket->local(), former.local());
  expect_burst(receive(*socket, 1), bytes, 100, sender.local());
}

TEST(UdpSocket, NamesAreNoPlaceToListen) {
  const auto socket = UdpSocket::open({"robot.invalid", 2010});
  ASSERT_FALSE(socket);
  EXPECT_EQ(socket.error().code(), Errc::kInvalidArgument);
  EXPECT_THAT(socket.error().detail(), testing::HasSubstr("robot.invalid"));
}

TEST(UdpSocket, NobodyThereIsNoError) {
  UdpSocket a = open("127.0.0.1");
  const NetAddress gone = open("127.0.0.1").local();
  const auto bytes = pattern(10, 10);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(a.send({gone, bytes, 10}), Sent::kAll);
  Datagrams datagrams;
  EXPECT_FALSE(a.receive(datagrams));
}

// --- Class of service

std::uint8_t traffic_class_of_next(int fd) {
  pollfd readable{fd, POLLIN, 0};
  EXPECT_EQ(::poll(&readable, 1, test::kPatienceMs), 1);
  alignas(cmsghdr) std::array<char, 256> control{};
  std::array<char, 2048> bytes{};
  iovec part{bytes.data(), bytes.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  EXPECT_GE(::recvmsg(fd, &message, 0), 0);
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if ((c->cmsg_level == IPPROTO_IP && c->cmsg_type == IP_TOS) ||
        (c->cmsg_level == IPPROTO_IPV6 && c->cmsg_type == IPV6_TCLASS))
      return *CMSG_DATA(c);
  }
  ADD_FAILURE() << "no class arrived";
  return 0xFF;
}

TEST(UdpSocket, ClassOfServiceArrives) {
  const int yes = 1;
  const UdpSocket v4 = open("127.0.0.1");
  const UdpSocket v6 = open("::1");
  ::setsockopt(v4.fd(), IPPROTO_IP, IP_RECVTOS, &yes, sizeof yes);
  ::setsockopt(v6.fd(), IPPROTO_IPV6, IPV6_RECVTCLASS, &yes, sizeof yes);
  const auto bytes = pattern(1000, 500);
  for (const bool segmentation : {true, false}) {
    UdpSocket from = open("::", {.segmentation = segmentation});
    for (const UdpSocket* to : {&v4, &v6}) {
      EXPECT_EQ(from.send({to->local(), std::span(bytes).first(500), 500, 46}), Sent::kAll);
      EXPECT_EQ(traffic_class_of_next(to->fd()), 46 << 2);
      EXPECT_EQ(from.send({to->local(), bytes, 1000, 0}), Sent::kAll);
      EXPECT_EQ(traffic_class_of_next(to->fd()), 0);
    }
  }
}

// --- With an interface as narrow as Ethernet

TEST(UdpSocketTest, KnowsWhatItCanReach) {
  const auto at = [](const char* host) { return *numeric_address(host, 2010); };
  struct Case {
    const char* from;
    std::vector<const char*> yes;
    std::vector<const char*> no;
  };
  for (const Case& c : {Case{"0.0.0.0", {"10.9.1.1", "127.0.0.1"}, {"fd00::1", "::1"}},
                        Case{"127.0.0.1", {"127.0.0.1", "127.9.0.1"}, {"10.9.1.1", "::1"}},
                        Case{"::", {"10.9.1.1", "fd00::1", "127.0.0.1", "::1"}, {}},
                        Case{"::1", {"::1"}, {"127.0.0.1", "fd00::1", "10.9.1.1"}}}) {
    const UdpSocket socket = open(c.from);
    for (const char* to : c.yes) EXPECT_TRUE(socket.can_reach(at(to))) << c.from << " " << to;
    for (const char* to : c.no) EXPECT_FALSE(socket.can_reach(at(to))) << c.from << " " << to;
  }
}

class UdpNarrow : public testing::Test {
 protected:
  void SetUp() override {
    auto entered = test::OwnNetwork::enter();
    if (!entered) GTEST_SKIP() << entered.error().message();
    network_.emplace(std::move(entered).value());
    ASSERT_TRUE(test::OwnNetwork::set_loopback_mtu(1500));
  }
  std::optional<test::OwnNetwork> network_{};
};

TEST_F(UdpNarrow, TooBigIsReportedAndNeverFragmented) {
  const auto bytes = pattern(6000, 1480);
  for (const char* host : {"127.0.0.1", "::1", "::"}) {
    UdpSocket a = open(host);
    UdpSocket b = open(host[0] == ':' && host[1] != '\0' ? "::1" : "127.0.0.1");
    EXPECT_EQ(a.send({b.local(), std::span(bytes).first(1480), 1480}), Sent::kTooBig) << host;
    EXPECT_EQ(a.send({b.local(), bytes, 1480}), Sent::kTooBig) << host;
    EXPECT_EQ(a.send({b.local(), bytes, 1452}), Sent::kAll) << host;
    receive(b, 5);
  }
}

TEST_F(UdpNarrow, TooBigGoesInFragmentsWhereAskedTo) {
  const auto bytes = pattern(6000, 1480);
  for (const char* host : {"127.0.0.1", "::1"}) {
    UdpSocket a = open(host, {.fragments = true});
    UdpSocket b = open(host);
    EXPECT_EQ(a.send({b.local(), std::span(bytes).first(1480), 1480}), Sent::kAll) << host;
    receive(b, 1);
    EXPECT_EQ(a.send({b.local(), bytes, 1480}), Sent::kAll) << host;
    receive(b, 5);
  }
}

TEST_F(UdpNarrow, WithoutRouteIsLost) {
  UdpSocket a = open("0.0.0.0");
  const auto bytes = pattern(1000, 500);
  EXPECT_EQ(a.send({NetAddress::v4(10, 9, 1, 1, 2010), bytes, 500}), Sent::kUnreachable);
}

}  // namespace udp_socket_test
}  // namespace tims::io

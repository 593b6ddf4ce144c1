#include "router/io/tcp_path.h"

#include <cstdint>
#include <memory>
#include <vector>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include "os/socket.h"
#include "router/io/tcp_path_fixture.h"
#include "router/link/datagram.h"
#include "tests/support/eventually.h"

namespace tims::io {
namespace tcp_path_test {

using namespace std::chrono_literals;
using link::NetAddress;
using Bytes = std::vector<std::byte>;

Bytes bytes_of(std::size_t size) { return Bytes(size, std::byte{7}); }

class TcpPathTest : public testing::Test {
 protected:
  void send(TcpHost& from, const NetAddress& to, const Bytes& bytes) {
    EXPECT_TRUE(from.send({.to = to, .bytes = bytes, .datagram_size = bytes.size()}));
  }
  [[nodiscard]] os::File guest() const {
    auto socket = os::connect_tcp("127.0.0.1", upper_.address.port, os::deadline_after(5s));
    EXPECT_TRUE(socket.ok());
    return std::move(*socket);
  }

  Loop loop_;
  TcpHost upper_{loop_};
  TcpHost lower_{loop_};
};

TEST_F(TcpPathTest, OneConnectionCarriesBothDirections) {
  send(lower_, upper_.address, bytes_of(256));
  ASSERT_TRUE(comes_true(
      loop_, [&] { return upper_.arrivals.size() == 1; }, "it arrives"));
  const NetAddress from = upper_.arrivals[0].from;
  EXPECT_EQ(from.kind, link::PathKind::kTcp);
  send(upper_, from, bytes_of(link::kDatagramMax));
  ASSERT_TRUE(comes_true(
      loop_, [&] { return lower_.arrivals.size() == 1; }, "the answer arrives"));
  EXPECT_EQ(lower_.arrivals[0].from, upper_.address);
  EXPECT_EQ(lower_.arrivals[0].bytes.size(), link::kDatagramMax);
  EXPECT_EQ(upper_.path.connections(), 1U);
  EXPECT_EQ(lower_.path.connections(), 1U);
}

// The side that accepts never connects: its routers below may be behind NAT.
TEST_F(TcpPathTest, OnlyCalledRoutersAreConnectedTo) {
  lower_.calls = false;
  send(lower_, upper_.address, bytes_of(10));
  EXPECT_EQ(lower_.path.connections(), 0U);
}

TEST_F(TcpPathTest, OneThatDoesNotReadLosesItsDatagramsOnly) {
  const os::File silent = guest();
  ASSERT_TRUE(comes_true(
      loop_, [&] { return upper_.path.connections() == 1; }, "it is connected"));
  std::uint8_t greeting[3] = {1, 0, 9};
  ASSERT_EQ(::send(silent.get(), greeting, sizeof greeting, 0), 3);
  ASSERT_TRUE(comes_true(
      loop_, [&] { return upper_.arrivals.size() == 1; }, "its datagram"));
  const NetAddress where = upper_.arrivals[0].from;
  const Bytes datagram = bytes_of(8000);
  for (int i = 0; i < 4000; ++i) send(upper_, where, datagram);  // 32 MB
  EXPECT_GT(upper_.path.lost(), 1000U);
  EXPECT_EQ(upper_.path.connections(), 1U) << "it is still connected";
  send(lower_, upper_.address, bytes_of(20));
  EXPECT_TRUE(comes_true(
      loop_, [&] { return upper_.arrivals.size() == 2; }, "others go on"));
}

TEST_F(TcpPathTest, WhatIsNoDatagramEndsTheConnection) {
  for (const std::string& garbage : {std::string("GET / HTTP/1.1\r\n\r\n"), std::string(2, '\0')}) {
    const os::File socket = guest();
    ASSERT_TRUE(comes_true(
        loop_, [&] { return upper_.path.connections() == 1; }, "it is connected"));
    (void)::send(socket.get(), garbage.data(), garbage.size(), 0);
    EXPECT_TRUE(comes_true(
        loop_, [&] { return upper_.path.connections() == 0; }, "it has ended"));
  }
  EXPECT_TRUE(upper_.arrivals.empty());
}

TEST_F(TcpPathTest, StrangersAreFewAndForAShortTime) {
  send(lower_, upper_.address, bytes_of(256));
  ASSERT_TRUE(comes_true(
      loop_, [&] { return upper_.arrivals.size() == 1; }, "a router"));
  upper_.linked.insert(upper_.arrivals[0].from);
  std::vector<os::File> guests;
  for (std::size_t i = 0; i < TcpPath::kStrangersMax + 20; ++i) {
    guests.push_back(guest());
    loop_.run_once(os::now() + 1ms);
  }
  EXPECT_TRUE(comes_true(
      loop_, [&] { return upper_.gone.size() == 20; }, "the oldest have ended"));
  EXPECT_EQ(upper_.path.connections(), 1 + TcpPath::kStrangersMax);
  upper_.path.on_timeout(os::now() + TcpPath::kStrangerTime + 1s);
  EXPECT_EQ(upper_.path.connections(), 1U) << "the router stays";
  EXPECT_FALSE(upper_.gone.contains(upper_.arrivals[0].from));
}

TEST_F(TcpPathTest, ARouterThatHasRestartedIsConnectedToAgain) {
  auto first = std::make_unique<TcpHost>(loop_);
  const NetAddress where = first->address;
  send(lower_, where, bytes_of(10));
  ASSERT_TRUE(comes_true(
      loop_, [&] { return first->arrivals.size() == 1; }, "it arrives"));
  first.reset();
  ASSERT_TRUE(comes_true(
      loop_, [&] { return lower_.gone.contains(where); }, "it has gone"));
  send(lower_, where, bytes_of(10));  // refused, or too early
  EXPECT_TRUE(comes_true(
      loop_, [&] { return lower_.path.connections() == 0; }, "nobody is there"));
}

}  // namespace tcp_path_test
}  // namespace tims::io

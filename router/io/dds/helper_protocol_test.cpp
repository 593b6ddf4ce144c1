#include "router/io/dds/helper_protocol.h"

#include <array>

#include <gtest/gtest.h>

namespace tims::io::helper {
namespace helper_protocol_test {

const link::NetAddress kPeer = link::NetAddress::dds({1, 15, 9, 4, 5, 6, 7, 8, 9, 10, 11, 12});

link::Announcement announcement() {
  return {.fleet = std::string_view("harbour"),
          .identity = {.epoch = 7,
                       .role = core::Role::kSystem,
                       .system = 3,
                       .id = 1,
                       .name = std::string_view("robot3"),
                       .message_max = 1 << 20},
          .dds = kPeer,
          .udp = {link::NetAddress::v4(10, 9, 1, 3, 2010)}};
}

struct HelperProtocol : testing::Test {
  // What the other side reads.
  template <typename Kind>
  Kind sent(const Kind& record) {
    size = encode(record, bytes);
    auto read = decode(std::span(bytes).first(size));
    EXPECT_TRUE(read && std::holds_alternative<Kind>(*read));
    return read && std::holds_alternative<Kind>(*read) ? std::get<Kind>(*read) : Kind{};
  }

  std::array<std::byte, kRecordMax> bytes{};
  std::size_t size = 0;
};

TEST_F(HelperProtocol, RecordsReadBack) {
  const DdsSettings settings{.fleet = "harbour",
                             .domain = 7,
                             .multicast = false,
                             .peers = {"10.9.1.1", "10.9.1.2:7410"},
                             .discovery_server = "10.9.1.9:11811",
                             .interface = "127.0.0.1",
                             .profiles = "/etc/tims/dds.xml",
                             .message_max = 9000,
                             .history = 5};
  const Start start = sent(Start{settings, announcement()});
  EXPECT_EQ(start.settings.fleet, settings.fleet);
  EXPECT_EQ(start.settings.domain, 7U);
  EXPECT_FALSE(start.settings.multicast);
  EXPECT_EQ(start.settings.peers, settings.peers);
  EXPECT_EQ(start.settings.discovery_server, settings.discovery_server);
  EXPECT_EQ(start.settings.interface, settings.interface);
  EXPECT_EQ(start.settings.profiles, settings.profiles);
  EXPECT_EQ(start.settings.lease, settings.lease);
  EXPECT_EQ(start.settings.message_max, 9000U);
  EXPECT_EQ(start.settings.history, 5U);
  EXPECT_EQ(start.settings.heartbeat, settings.heartbeat);
  EXPECT_EQ(start.self, announcement());
  EXPECT_EQ(sent(Restart{announcement()}).self, announcement());
  EXPECT_EQ(sent(Announced{announcement()}).announcement, announcement());
  EXPECT_EQ(sent(Connect{kPeer}).to, kPeer);
  EXPECT_EQ(sent(Gone{kPeer}).dds, kPeer);
  EXPECT_EQ(sent(Started{"no such file"}).error, "no such file");
  (void)sent(Stop{});
  const Report report = sent(Report{.state = DdsEngine::State::kUp,
                                    .address = kPeer,
                                    .host = {link::NetAddress::v4(10, 9, 1, 3, 1), kPeer},
                                    .last_error = "late",
                                    .counters = {.samples_out = 3, .waiting_bytes = 9}});
  EXPECT_EQ(report.state, DdsEngine::State::kUp);
  EXPECT_EQ(report.address, kPeer);
  EXPECT_EQ(report.host, (std::vector{link::NetAddress::v4(10, 9, 1, 3, 1), kPeer}));
  EXPECT_EQ(report.last_error, "late");
  EXPECT_EQ(report.counters.samples_out, 3U);
  EXPECT_EQ(report.counters.waiting_bytes, 9U);
}

TEST_F(HelperProtocol, DatagramsReadBack) {
  const std::vector<std::byte> all(link::kBurstBytesMax, std::byte{7});
  const link::Burst burst =
      sent(link::Burst{.to = kPeer, .bytes = all, .datagram_size = 1400, .dscp = 46});
  EXPECT_EQ(burst.to, kPeer);
  EXPECT_EQ(burst.datagram_size, 1400U);
  EXPECT_EQ(burst.dscp, 46);
  EXPECT_TRUE(std::ranges::equal(burst.bytes, all));
  std::vector<std::byte> batch{std::byte{2}, std::byte{0}, std::byte{0xAB}, std::byte{0xCD}};
  const Arrived arrived = sent(Arrived{kPeer, batch});
  EXPECT_EQ(arrived.from, kPeer);
  EXPECT_TRUE(std::ranges::equal(arrived.batch, batch));
}

TEST_F(HelperProtocol, OtherBytesAreRefused) {
  EXPECT_FALSE(decode({}));
  for (int kind = 10; kind < 256; ++kind) {
    bytes[0] = static_cast<std::byte>(kind);
    EXPECT_FALSE(decode(std::span(bytes).first(1)));
  }
  (void)sent(Connect{kPeer});
  for (std::size_t some = 0; some < size; ++some)
    EXPECT_FALSE(decode(std::span(bytes).first(some))) << some;
  EXPECT_FALSE(decode(std::span(bytes).first(size + 1)));
  std::vector<std::byte> batch{std::byte{9}, std::byte{0}, std::byte{0xAB}};
  const std::size_t damaged = encode(Arrived{kPeer, batch}, bytes);
  EXPECT_FALSE(decode(std::span(bytes).first(damaged))) << "a size beyond its end";
  const std::vector<std::byte> data(100);
  for (const std::size_t datagram : {std::size_t{0}, std::size_t{1}, link::kDatagramMax + 1}) {
    const std::size_t burst =
        encode(link::Burst{.to = kPeer, .bytes = data, .datagram_size = datagram}, bytes);
    EXPECT_FALSE(decode(std::span(bytes).first(burst))) << datagram;
  }
}

// Only over DDS has the helper anything to tell.
TEST_F(HelperProtocol, AddressesOfOtherPathsAreRefused) {
  const auto is_read = [&](const Record& record) {
    return decode(std::span(bytes).first(encode(record, bytes))).has_value();
  };
  std::vector<std::byte> batch{std::byte{2}, std::byte{0}, std::byte{0xAB}, std::byte{0xCD}};
  for (const link::PathKind kind : {link::PathKind::kUdp, link::PathKind::kTcp}) {
    link::NetAddress other = kPeer;
    other.kind = kind;
    link::Announcement announced = announcement();
    announced.dds = other;
    EXPECT_FALSE(is_read(Arrived{other, batch}));
    EXPECT_FALSE(is_read(Announced{announced}));
    EXPECT_FALSE(is_read(Gone{other}));
  }
  EXPECT_TRUE(is_read(Arrived{kPeer, batch}));
  EXPECT_TRUE(is_read(Announced{announcement()}));
  EXPECT_TRUE(is_read(Gone{kPeer}));
}

TEST_F(HelperProtocol, WhatDoesNotFitIsNotEncoded) {
  const std::vector<std::byte> all(kRecordMax);
  EXPECT_EQ(encode(link::Burst{.to = kPeer, .bytes = all, .datagram_size = 1400}, bytes), 0U);
}

}  // namespace helper_protocol_test
}  // namespace tims::io::helper

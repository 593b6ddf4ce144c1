#include "router/io/dds/discovery_filter.h"

#include <gtest/gtest.h>

namespace tims::io {
namespace discovery_filter_test {

using namespace std::chrono_literals;
using link::DdsParticipant;
using link::Role;
using Bytes = std::vector<std::byte>;

constexpr DdsParticipant kSelf{9};
const link::NetAddress kWhere = link::NetAddress::v4(10, 9, 1, 7, 7412);

link::Announcement announcement(std::uint64_t epoch, Role role, const char* fleet = "fleet") {
  return {.fleet = std::string_view(fleet),
          .identity = {.epoch = epoch, .role = role, .system = 1}};
}

void put(Bytes& to, std::initializer_list<int> octets) {
  for (const int octet : octets) to.push_back(static_cast<std::byte>(octet));
}

Bytes header(const DdsParticipant& from) {
  Bytes message;
  put(message, {'R', 'T', 'P', 'S', 2, 2, 1, 15});
  for (const std::uint8_t octet : from) put(message, {octet});
  return message;
}

// DATA(p), little-endian, as Fast DDS writes it.
Bytes announces(const DdsParticipant& from, const link::Announcement& what) {
  Bytes message = header(from);
  put(message, {0x15, 0x05, 0, 0, 0, 0, 16, 0, 0, 1, 0, 0xC7, 0, 1, 0, 0xC2});
  put(message, {0, 0, 0, 0, 1, 0, 0, 0, 0, 3, 0, 0});
  put(message, {0x02, 0, 8, 0, 4, 0, 0, 0, 0, 0, 0, 0x80});  // lease: 4.5 s
  put(message, {0x32, 0, 24, 0, 1, 0, 0, 0, 0xF4, 0x1C, 0, 0});
  put(message, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 10, 9, 1, 7});
  Bytes octets = encode(what);
  const std::size_t size = octets.size();
  octets.resize((size + 3) / 4 * 4);
  put(message, {0x2C, 0, static_cast<int>(octets.size() + 4), 0, static_cast<int>(size), 0, 0, 0});
  message.insert(message.end(), octets.begin(), octets.end());
  put(message, {1, 0, 0, 0});
  return message;
}

Bytes announces(std::uint8_t number, Role role, const char* fleet = "fleet") {
  return announces(DdsParticipant{number}, announcement(number, role, fleet));
}

// An INFO_DST, and something that is none of ours.
Bytes addresses(const DdsParticipant& from, const DdsParticipant& to) {
  Bytes message = header(from);
  put(message, {0x06, 0x01, 4, 0, 1, 2, 3, 4});
  return directed(message, to);
}

Bytes ends(const DdsParticipant& from) {
  Bytes message = header(from);
  put(message, {0x15, 0x03, 0, 0, 0, 0, 16, 0, 0, 1, 0, 0xC7, 0, 1, 0, 0xC2});
  put(message, {0, 0, 0, 0, 2, 0, 0, 0, 0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0});
  return message;
}

class DiscoveryFilterTest : public testing::Test {
 protected:
  DiscoveryFilter::Verdict receive(const Bytes& message, bool multicast = true) {
    return filter.on_message(now, message, multicast);
  }
  void announce_self() { filter.on_own(announces(kSelf, announcement(9, Role::kTop))); }

  Time now{1h};
  DiscoveryFilter filter{announcement(9, Role::kTop)};
};

TEST_F(DiscoveryFilterTest, ARouterIsKnownAndHeldUntilItIsWanted) {
  const Bytes message = announces(1, Role::kSystem);
  const auto first = receive(message);
  EXPECT_FALSE(first.passes);
  ASSERT_TRUE(first.announced);
  EXPECT_EQ(first.announced->dds, link::NetAddress::dds({1}));
  EXPECT_EQ(first.announced->identity.epoch, 1);
  const auto again = receive(message);
  EXPECT_FALSE(again.passes || again.announced);
  EXPECT_FALSE(receive(addresses({1}, {2})).passes) << "for another participant";
  EXPECT_EQ(filter.admit({1}), message);
  EXPECT_TRUE(filter.admit({1}).empty()) << "once";
  EXPECT_TRUE(receive(message).passes);
  EXPECT_TRUE(receive(addresses({1}, {2})).passes);
  filter.forget({1});
  const auto rediscovered = receive(message);
  EXPECT_FALSE(rediscovered.passes);
  EXPECT_TRUE(rediscovered.announced);
}

// The filter is new after a change of addresses, and those we send to are still the same.
TEST_F(DiscoveryFilterTest, ARouterThatIsWantedIsAdmittedWhenItIsAnnounced) {
  announce_self();
  EXPECT_TRUE(filter.admit({1}).empty());
  const auto first = receive(announces(1, Role::kSystem));
  EXPECT_TRUE(first.announced);
  EXPECT_TRUE(first.passes);
  EXPECT_TRUE(first.answer.empty()) << "the library does it";
  const auto second = receive(announces(1, Role::kSystem));
  EXPECT_TRUE(second.passes);
  EXPECT_FALSE(second.announced);
  EXPECT_FALSE(receive(announces(2, Role::kSystem)).passes);
}

TEST_F(DiscoveryFilterTest, AParticipantThatAddressesUsIsAdmitted) {
  announce_self();
  EXPECT_FALSE(receive(addresses({1}, kSelf)).passes) << "it is unknown";
  const Bytes message = announces(1, Role::kSystem);
  (void)receive(message);
  const auto verdict = receive(addresses({1}, kSelf));
  EXPECT_TRUE(verdict.passes);
  EXPECT_EQ(verdict.first, message);
  EXPECT_TRUE(receive(addresses({1}, kSelf)).first.empty());
}

// A fleet that loses UDP at once addresses the router above all at once.
TEST_F(DiscoveryFilterTest, AFewASecondAreAdmittedThatAddressUs) {
  announce_self();
  const auto admitted = [&] {
    std::size_t n = 0;
    for (std::uint8_t i = 10; i < 100; ++i)
      n += receive(addresses({i}, kSelf)).first.empty() ? 0 : 1;
    return n;
  };
  for (std::uint8_t i = 10; i < 100; ++i) (void)receive(announces(i, Role::kSystem));
  EXPECT_EQ(admitted(), DiscoveryFilter::kAdmittedPerSecond);
  EXPECT_EQ(admitted(), 0);
  EXPECT_FALSE(filter.admit({99}).empty()) << "those we send to do not wait";
  now += 1s;
  EXPECT_EQ(admitted(), DiscoveryFilter::kAdmittedPerSecond);
  now += 10s;
  EXPECT_EQ(admitted(), DiscoveryFilter::kAdmittedPerSecond);
}

TEST_F(DiscoveryFilterTest, OtherFleetsAreIgnored) {
  EXPECT_FALSE(receive(announces(1, Role::kSystem, "others")).announced);
  EXPECT_FALSE(receive(announces(2, Role::kSystem, "others")).passes);
  EXPECT_FALSE(receive(announces(9, Role::kTop)).announced) << "our own epoch";
  Bytes none = announces(1, Role::kSystem);
  none[0] = std::byte{'X'};
  EXPECT_FALSE(receive(none).announced || receive({}).announced);
  EXPECT_TRUE(filter.admit({1}).empty());
}

TEST_F(DiscoveryFilterTest, WhatIsCutShortHarmsNobody) {
  const Bytes whole = announces(1, Role::kSystem);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    DiscoveryFilter fresh{announcement(9, Role::kTop)};
    (void)fresh.on_message(now, std::span(whole).first(size), true);
  }
}

TEST_F(DiscoveryFilterTest, AParticipantThatLooksForUsIsAnswered) {
  EXPECT_TRUE(receive(announces(1, Role::kSystem)).answer.empty())
      << "no announcement of our own yet";
  announce_self();
  const auto verdict = receive(announces(1, Role::kSystem));
  EXPECT_EQ(verdict.to, std::vector{kWhere});
  const auto answer = parse_rtps(verdict.answer);
  ASSERT_TRUE(answer && answer->announced);
  EXPECT_EQ(answer->from, kSelf);
  EXPECT_EQ(answer->to, DdsParticipant{1});
  EXPECT_TRUE(receive(announces(2, Role::kTop)).answer.empty()) << "it looks for no router";
  EXPECT_TRUE(receive(announces(3, Role::kSubsystem)).answer.empty()) << "not for us";
  EXPECT_FALSE(receive(announces(3, Role::kSubsystem), false).answer.empty()) << "by address";
  EXPECT_TRUE(receive(directed(announces(4, Role::kSystem), kSelf), false).answer.empty())
      << "is an answer";
  (void)filter.admit({1});
  EXPECT_TRUE(receive(announces(1, Role::kSystem)).answer.empty()) << "the library does it";
}

// Without multicast and peers there is nothing of ours to be repeated.
TEST_F(DiscoveryFilterTest, TheLibraryAnswersUnicastBeforeWeAnnounced) {
  const auto verdict = receive(announces(1, Role::kSystem), false);
  EXPECT_TRUE(verdict.passes);
  EXPECT_TRUE(verdict.announced);
}

TEST_F(DiscoveryFilterTest, ALeavingOrSilentParticipantIsGone) {
  (void)receive(announces(1, Role::kSystem));
  EXPECT_EQ(receive(ends({1})).gone, DdsParticipant{1});
  EXPECT_FALSE(receive(ends({1})).gone);
  (void)receive(announces(1, Role::kSystem));
  (void)receive(announces(2, Role::kSystem));
  now += 4499ms;
  EXPECT_TRUE(filter.expire(now).empty());
  (void)receive(announces(2, Role::kSystem));
  now += 2ms;
  EXPECT_EQ(filter.expire(now), std::vector{DdsParticipant{1}});
  EXPECT_TRUE(filter.expire(now).empty());
}

// The library may receive them on other paths.
TEST_F(DiscoveryFilterTest, WhomTheLibraryKnowsItJudgesItself) {
  (void)receive(announces(1, Role::kSystem));
  (void)filter.admit({1});
  now += 3 * 4500ms - 1ms;
  EXPECT_TRUE(filter.expire(now).empty());
  now += 1ms;
  EXPECT_EQ(filter.expire(now).size(), 1) << "and if it never did";
}

TEST_F(DiscoveryFilterTest, KnowsNoMoreThanItsLimit) {
  const auto of = [](std::size_t i) {
    return announces(
        DdsParticipant{1, static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8)},
        announcement(i + 100, Role::kSystem));
  };
  for (std::size_t i = 0; i < DiscoveryFilter::kRoutersMax; ++i)
    ASSERT_TRUE(receive(of(i)).announced) << i;
  EXPECT_FALSE(receive(of(DiscoveryFilter::kRoutersMax)).announced);
  (void)receive(ends({1, 7}));
  EXPECT_TRUE(receive(of(DiscoveryFilter::kRoutersMax)).announced);
}

std::vector<std::byte> bytes(std::initializer_list<int> octets) {
  std::vector<std::byte> made;
  for (const int octet : octets) made.push_back(static_cast<std::byte>(octet));
  return made;
}

TEST(RtpsMessage, OfTheOtherByteOrderIsRead) {
  const auto message = bytes({'R',  'T',  'P', 'S',  2, 3, 1, 15,    // header
                              1,    2,    3,   4,    5, 6, 7, 8,     // from
                              9,    10,   11,  12,                   //
                              0x15, 4,    0,   0,    0, 0, 0, 16,    // DATA
                              0,    1,    0,   0xC7, 0, 1, 0, 0xC2,  // of SPDP
                              0,    0,    0,   0,    0, 0, 0, 1,     //
                              0,    2,    0,   0,                    // PL_CDR_BE
                              0,    2,    0,   8,    0, 0, 0, 7,     // lease
                              0,    0,    0,   0,                    //
                              0,    0x2C, 0,   8,    0, 0, 0, 3,     // user data
                              'a',  'b',  'c', 0,    0, 1, 0, 0});
  const auto read = parse_rtps(message);
  ASSERT_TRUE(read && read->announced);
  EXPECT_EQ(read->from, (link::DdsParticipant{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
  EXPECT_EQ(read->announced->lease, std::chrono::seconds(7));
  EXPECT_EQ(read->announced->user_data.size(), 3);
  EXPECT_FALSE(read->to || read->ends);
}

TEST(RtpsMessage, TheSenderStandsInTheHeader) {
  const auto message =
      bytes({'R', 'T', 'P', 'S', 2, 3, 1, 15, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  EXPECT_EQ(rtps_sender(message), (link::DdsParticipant{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
  EXPECT_FALSE(rtps_sender(std::span(message).first(19)));
  EXPECT_FALSE(rtps_sender(std::vector<std::byte>(20)));
}

TEST(RtpsMessage, AHeartbeatNamesTheAvailableSamples) {
  const auto message = encode(RtpsHeartbeat{.from = {1},
                                            .writer = {0, 0, 2, 3},
                                            .to = {7},
                                            .first = 5,
                                            .last = (1ULL << 32) + 6,
                                            .count = 0x10001});
  const auto read = parse_rtps(message);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->from, link::DdsParticipant{1});
  EXPECT_EQ(read->to, link::DdsParticipant{7});
  const auto expected = bytes({7, 1, 28, 0, 0, 0, 0, 0, 0, 0, 2, 3, 0, 0, 0, 0,  //
                               5, 0, 0,  0, 1, 0, 0, 0, 6, 0, 0, 0, 1, 0, 1, 0});
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), message.end() - 32));
}

}  // namespace discovery_filter_test

}  // namespace tims::io

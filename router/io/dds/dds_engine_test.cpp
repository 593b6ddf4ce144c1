#include "router/io/dds/dds_engine.h"

#include <atomic>
#include <filesystem>
#include <numeric>
#include <thread>

#include <gmock/gmock.h>

#include "tests/support/dds_fixture.h"

namespace tims::io {
namespace {

using testing::Contains;
using testing::HasSubstr;

// Each datagram begins with its number and is filled with it.
Bytes numbered(std::uint32_t number, std::size_t size) {
  Bytes bytes(size, static_cast<std::byte>(number));
  for (std::size_t i = 0; i < std::min<std::size_t>(4, size); ++i)
    bytes[i] = static_cast<std::byte>(number >> (8 * i));
  return bytes;
}

TEST_F(DdsEngineTest, RoutersOfAFleetSeeEachOther) {
  Host a(loop_, "a");
  Host b(loop_, "b");
  meet(a, b);
  EXPECT_EQ(a.seen.at(0).udp, b.self.udp);
  EXPECT_NE(a.address(), b.address());
  const auto address = b.address();
  b.engine.stop();
  EXPECT_EQ(b.engine.state(), DdsEngine::State::kOff);
  EXPECT_TRUE(until([&] { return !a.gone.empty(); }, "a hears that b went"));
  EXPECT_THAT(a.gone, Contains(address));
}

TEST_F(DdsEngineTest, OtherFleetsAreNotSeen) {
  Host a(loop_, "a");
  Host stranger(loop_, "stranger", {.fleet = test_fleet("others")});
  Host b(loop_, "b");
  ASSERT_TRUE(stranger.start());
  meet(a, b);
  ASSERT_TRUE(until([&] { return stranger.is_up(); }, "the stranger is up"));
  // They had as much time as a and b.
  EXPECT_FALSE(a.sees(stranger) || stranger.sees(a) || stranger.sees(b));
  EXPECT_FALSE(a.send(stranger.address(), Bytes(10), 10));
}

TEST_F(DdsEngineTest, TrainsOfAllSizesArriveInOrderBothWays) {
  Host a(loop_, "a");
  Host b(loop_, "b");
  meet(a, b);
  std::vector<Bytes> sent;
  const auto send = [&](std::size_t bytes, std::size_t datagram_size) {
    Bytes train(bytes);
    std::iota(reinterpret_cast<unsigned char*>(train.data()),
              reinterpret_cast<unsigned char*>(train.data() + bytes), sent.size() & 0xFF);
    ASSERT_TRUE(a.send(b.address(), train, datagram_size));
    ASSERT_TRUE(b.send(a.address(), train, datagram_size));
    for (std::size_t at = 0; at < bytes; at += datagram_size) {
      const auto end = std::min(bytes, at + datagram_size);
      sent.emplace_back(train.begin() + static_cast<std::ptrdiff_t>(at),
                        train.begin() + static_cast<std::ptrdiff_t>(end));
    }
  };
  for (std::size_t size = 1; size <= 8972; size = size * 3 / 2 + 1) send(size, size);
  send(8972, 8972);
  send(link::kTrainBytesMax, 8972);
  send(std::size_t{64} * 40, 40);
  send(63 * 1200 + 7, 1200);
  ASSERT_TRUE(
      until([&] { return a.arrivals.size() >= sent.size() && b.arrivals.size() >= sent.size(); },
            "all have arrived"))
      << a.arrivals.size() << " and " << b.arrivals.size() << " of " << sent.size();
  ASSERT_EQ(a.arrivals.size(), sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    ASSERT_EQ(b.arrivals[i].bytes, sent[i]) << "number " << i;
    ASSERT_EQ(a.arrivals[i].bytes, sent[i]) << "number " << i;
    ASSERT_EQ(b.arrivals[i].from, a.address());
  }
  EXPECT_TRUE(until([&] { return a.engine.counters().datagrams_out == sent.size(); }, "counted"));
  EXPECT_EQ(a.engine.counters().bytes_in, a.bytes_in);
}

// Several times what the queue and the histories hold.
TEST_F(DdsEngineTest, NothingOfAFloodIsLostWhenTheSenderTriesAgain) {
  constexpr std::uint32_t kDatagrams = 30'000;
  constexpr std::size_t kSize = 1200;
  Host a(loop_, "a");
  Host b(loop_, "b");
  meet(a, b);
  b.keeps = false;
  std::uint32_t next = 0;
  ASSERT_TRUE(until(
      [&] {
        while (next < kDatagrams && a.send(b.address(), numbered(next, kSize), kSize)) ++next;
        return b.engine.counters().datagrams_in >= kDatagrams &&
               a.engine.counters().waiting_bytes == 0;
      },
      "all have arrived"));
  EXPECT_EQ(b.bytes_in, kDatagrams * kSize);
  EXPECT_GT(a.engine.counters().refused, 0) << "the flood was none";
}

TEST_F(DdsEngineTest, ARouterThatDoesNotReadHoldsUpNobodyElse) {
  Loop asleep;
  Host a(loop_, "a");
  Host deaf(asleep, "deaf");
  Host b(loop_, "b");
  ASSERT_TRUE(deaf.start());
  ASSERT_TRUE(run_until(
      asleep, [&] { return deaf.is_up(); }, "the deaf one is up"));
  meet(a, b);
  ASSERT_TRUE(until([&] { return a.sees(deaf); }, "a sees the deaf one"));
  const Bytes train(60'000);
  ASSERT_TRUE(until([&] { return !a.send(deaf.address(), train, 1200); }, "its queue is full"));
  const auto counters = a.engine.counters();
  EXPECT_LE(counters.waiting_bytes, 4U << 20);
  // And stays full: the histories are bounded too.
  ASSERT_TRUE(until([&] { return a.engine.counters().bytes_out >= 12 * train.size(); }, "written"));
  std::uint32_t answered = 0;
  for (std::uint32_t i = 0; i < 200; ++i) {
    ASSERT_TRUE(a.send(b.address(), numbered(i, 100), 100));
    (void)a.send(deaf.address(), train, 1200);
    ASSERT_TRUE(until([&] { return b.arrivals.size() > i; }, "b has got it")) << i;
    ++answered;
  }
  EXPECT_EQ(answered, 200);
  EXPECT_LT(a.engine.counters().bytes_out, 40U << 20);
}

TEST_F(DdsEngineTest, RestartGivesANewAddressAndGoesOn) {
  Host a(loop_, "a");
  Host b(loop_, "b");
  meet(a, b);
  ASSERT_TRUE(a.send(b.address(), numbered(1, 50), 50));
  ASSERT_TRUE(until([&] { return b.arrivals.size() == 1; }, "the first has arrived"));
  const auto before = a.address();
  a.self.who.epoch = 2;
  a.engine.restart(a.self);
  EXPECT_FALSE(a.is_up());
  // What is sent meanwhile waits for the new participant.
  EXPECT_TRUE(a.send(b.address(), numbered(2, 50), 50));
  ASSERT_TRUE(until([&] { return a.is_up() && b.sees(a) && a.sees(b); }, "known again"));
  EXPECT_NE(a.address(), before);
  EXPECT_THAT(b.gone, Contains(before));
  ASSERT_TRUE(a.send(b.address(), numbered(3, 50), 50));
  ASSERT_TRUE(b.send(a.address(), numbered(4, 50), 50));
  ASSERT_TRUE(
      until([&] { return b.arrivals.size() == 3 && a.arrivals.size() == 1; }, "all have arrived"));
  EXPECT_EQ(b.arrivals[1].bytes, numbered(2, 50));
  EXPECT_EQ(b.arrivals[2].from, a.address());
  EXPECT_TRUE(a.gone.empty());
}

TEST_F(DdsEngineTest, WhoWentDuringARestartIsGone) {
  Host a(loop_, "a", {.lease = std::chrono::seconds(1)});
  Host b(loop_, "b");
  meet(a, b);
  const auto address = b.address();
  a.engine.restart(a.self);
  b.engine.stop();
  EXPECT_TRUE(until([&] { return a.is_up() && !a.gone.empty(); }, "a hears that b went"));
  EXPECT_THAT(a.gone, Contains(address));
  EXPECT_FALSE(a.send(address, Bytes(10), 10));
}

// The end of an engine waits for the other router, which lives meanwhile.
TEST_F(DdsEngineTest, LastWordsArrive) {
  Loop own;
  Host a(own, "a");
  Host b(loop_, "b");
  ASSERT_TRUE(a.start() && b.start());
  std::atomic<bool> over = false;
  std::thread other([&] {
    while (!over) loop_.run_once(os::now() + std::chrono::milliseconds(1));
  });
  const auto until_a = [&](auto condition, const char* what) {
    EXPECT_TRUE(run_until(own, condition, what));
  };
  until_a([&] { return a.seen.size() == 1; }, "a sees b");
  bool sent = true;
  for (std::uint32_t i = 0; i < 500; ++i) sent &= a.send(a.seen[0].dds, numbered(i, 1200), 1200);
  EXPECT_TRUE(sent);
  until_a([&] { return a.engine.counters().samples_out > 0; }, "they have met");
  a.engine.stop();
  over = true;
  other.join();
  EXPECT_TRUE(until([&] { return b.arrivals.size() == 500; }, "all have arrived"));
}

// --- Starting and stopping

std::size_t count_of(const char* folder, const std::string& with) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    count += entry.path().filename().string().find(with) != std::string::npos;
  return count;
}

TEST_F(DdsEngineTest, StartsAndStopsAgainAndAgainAndLeavesNothing) {
  const std::size_t shared = count_of("/dev/shm", "fastrtps");
  std::size_t descriptors = 0;
  for (int i = 0; i < 20; ++i) {
    Host a(loop_, "a");
    ASSERT_TRUE(a.start());
    if (i % 2 == 0) {
      ASSERT_TRUE(until([&] { return a.is_up(); }, "it is up"));
    }
    a.engine.stop();
    a.engine.stop();
    if (i == 2) descriptors = count_of("/proc/self/fd", "");
  }
  EXPECT_LE(count_of("/proc/self/fd", ""), descriptors);
  EXPECT_EQ(count_of("/dev/shm", "fastrtps"), shared);
}

TEST_F(DdsEngineTest, StartsAgainAfterStop) {
  Host a(loop_, "a");
  Host b(loop_, "b");
  meet(a, b);
  b.engine.stop();
  ASSERT_TRUE(until([&] { return a.seen.empty(); }, "a hears that b went"));
  b.seen.clear();
  ASSERT_TRUE(b.start());
  ASSERT_TRUE(until([&] { return b.is_up() && a.sees(b) && b.sees(a); }, "they meet again"));
}

TEST_F(DdsEngineTest, NobodyIsSentToUnlessAnnounced) {
  Host a(loop_, "a");
  EXPECT_FALSE(a.send(link::NetAddress::dds({1}), Bytes(10), 10)) << "not even started";
  ASSERT_TRUE(a.start());
  ASSERT_TRUE(until([&] { return a.is_up(); }, "it is up"));
  EXPECT_FALSE(a.send(link::NetAddress::dds({1}), Bytes(25), 10));
  EXPECT_EQ(a.engine.counters().refused, 3);
}

// --- Settings that cannot work

struct Bad {
  const char* name;
  DdsSettings settings;
  const char* says;
};

class BadSettings : public testing::TestWithParam<Bad> {};

TEST_P(BadSettings, AreRefusedAtTheStart) {
  Loop loop;
  Host a(loop, "a", GetParam().settings);
  const auto started = a.start();
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().message(), HasSubstr(GetParam().says));
  EXPECT_EQ(a.engine.state(), DdsEngine::State::kOff);
}

INSTANTIATE_TEST_SUITE_P(
    DdsEngine, BadSettings,
    testing::Values(Bad{"Domain", {.domain = 233}, "domain 233"},
                    Bad{"Peer", {.peers = {"10.9.1.1", "robot"}}, "peer robot"},
                    Bad{"PeerPort", {.peers = {"10.9.1.1:70000"}}, "10.9.1.1:70000"},
                    Bad{"Server", {.discovery_server = "here:11811"}, "here:11811"},
                    Bad{"Interface", {.interface = "eth0"}, "interface eth0"},
                    Bad{"NoProfiles", {.profiles = "/nowhere/dds.xml"}, "/nowhere/dds.xml"}),
    [](const auto& bad) { return bad.param.name; });

}  // namespace
}  // namespace tims::io

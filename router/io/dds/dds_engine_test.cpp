#include "router/io/dds/dds_engine.h"

#include <atomic>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <thread>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <gmock/gmock.h>

#include "libtims/os/clock.h"
#include "router/io/dds/foreign_participant_fixture.h"
#include "router/io/dds/transport.h"
#include "router/io/dds/writer.h"
#include "tests/support/child_process.h"
#include "tests/support/dds_fixture.h"
#include "tests/support/own_network.h"
#include "tests/support/temporary_folder.h"

namespace tims::io {
namespace dds_engine_test {

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
  EXPECT_TRUE(until([&] { return !a.gone.empty(); }, "a notices that b has gone"));
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

TEST_F(DdsEngineTest, BurstsOfAllSizesArriveInOrderBothWays) {
  Host a(loop_, "a");
  Host b(loop_, "b");
  meet(a, b);
  std::vector<Bytes> sent;
  const auto send = [&](std::size_t bytes, std::size_t datagram_size) {
    Bytes burst(bytes);
    std::iota(reinterpret_cast<unsigned char*>(burst.data()),
              reinterpret_cast<unsigned char*>(burst.data() + bytes), sent.size() & 0xFF);
    ASSERT_TRUE(a.send(b.address(), burst, datagram_size));
    ASSERT_TRUE(b.send(a.address(), burst, datagram_size));
    for (std::size_t at = 0; at < bytes; at += datagram_size) {
      const auto end = std::min(bytes, at + datagram_size);
      sent.emplace_back(burst.begin() + static_cast<std::ptrdiff_t>(at),
                        burst.begin() + static_cast<std::ptrdiff_t>(end));
    }
  };
  for (std::size_t size = 1; size <= 8972; size = size * 3 / 2 + 1) send(size, size);
  send(8972, 8972);
  send(link::kBurstBytesMax, 8972);
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
  Host stalled(asleep, "stalled");
  Host b(loop_, "b");
  ASSERT_TRUE(stalled.start());
  ASSERT_TRUE(run_until(
      asleep, [&] { return stalled.is_up(); }, "the stalled one is up"));
  meet(a, b);
  ASSERT_TRUE(until([&] { return a.sees(stalled); }, "a sees the stalled one"));
  const Bytes burst(60'000);
  ASSERT_TRUE(until([&] { return !a.send(stalled.address(), burst, 1200); }, "its queue is full"));
  const auto counters = a.engine.counters();
  EXPECT_LE(counters.waiting_bytes, 4U << 20);
  // And stays full: the histories are bounded too.
  ASSERT_TRUE(until([&] { return a.engine.counters().bytes_out >= 12 * burst.size(); }, "written"));
  std::uint32_t answered = 0;
  for (std::uint32_t i = 0; i < 200; ++i) {
    ASSERT_TRUE(a.send(b.address(), numbered(i, 100), 100));
    (void)a.send(stalled.address(), burst, 1200);
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
  a.self.identity.epoch = 2;
  a.engine.restart(a.self);
  EXPECT_FALSE(a.is_up());
  // Datagrams sent in between wait for the new participant.
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

TEST_F(DdsEngineTest, ARouterThatWentDuringARestartIsGone) {
  Host a(loop_, "a", {.lease = std::chrono::seconds(1)});
  Host b(loop_, "b");
  meet(a, b);
  const auto address = b.address();
  a.engine.restart(a.self);
  b.engine.stop();
  EXPECT_TRUE(until([&] { return a.is_up() && !a.gone.empty(); }, "a notices that b has gone"));
  EXPECT_THAT(a.gone, Contains(address));
  EXPECT_FALSE(a.send(address, Bytes(10), 10));
}

// Stopping an engine waits for the other router, which is still running.
TEST_F(DdsEngineTest, DataSentBeforeStoppingArrives) {
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
  ASSERT_TRUE(until([&] { return a.seen.empty(); }, "a notices that b has gone"));
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
  const char* reason;
};

void PrintTo(const Bad& bad, std::ostream* out) { *out << bad.name; }

class BadSettings : public testing::TestWithParam<Bad> {};

TEST_P(BadSettings, AreRefusedAtTheStart) {
  Loop loop;
  Host a(loop, "a", GetParam().settings);
  const auto started = a.start();
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().message(), HasSubstr(GetParam().reason));
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

// Discovery of routers, of foreign participants, and of their departure.

using testing::HasSubstr;
using namespace std::chrono_literals;

std::string partition_of(const Host& host) {
  const std::string text = host.address().to_string();
  return text.substr(text.find(':') + 1);
}

Bytes bytes(std::initializer_list<int> values) {
  Bytes made;
  for (const int value : values) made.push_back(static_cast<std::byte>(value));
  return made;
}

TEST_F(DdsEngineTest, GarbageOfOthersIsCountedAndHarmsNobody) {
  Host a(loop_, "a");
  Host b(loop_, "b");
  meet(a, b);
  const auto announcement = announcement_of("stranger", test_fleet());
  ForeignParticipant stranger(test_domain(), ForeignParticipant::router(announcement));
  stranger.open("tims/" + test_fleet(), partition_of(a));
  ASSERT_TRUE(until([&] { return stranger.is_matched(); }, "the stranger reaches a"));
  stranger.write({});
  stranger.write(bytes({5}));
  stranger.write(bytes({200, 0, 1, 2, 3}));
  stranger.write(Bytes(50'000, std::byte{0xFF}));
  stranger.write(bytes({2, 0, 0xAB, 0xCD}));  // well-formed: the links check the sender
  ASSERT_TRUE(b.send(a.address(), Bytes(10), 10));
  ASSERT_TRUE(until([&] { return a.arrivals.size() == 2; }, "two datagrams"));
  ASSERT_TRUE(until([&] { return a.engine.counters().strange == 4; }, "four are strange"));
}

TEST_F(DdsEngineTest, AParticipantThatIsNotARouterOfTheFleetReachesNobody) {
  Host a(loop_, "a");
  Host b(loop_, "b");
  meet(a, b);
  ForeignParticipant other(test_domain());
  other.open("tims/" + test_fleet(), partition_of(a));
  const auto announcement = announcement_of("stranger", test_fleet());
  ForeignParticipant stranger(test_domain(), ForeignParticipant::router(announcement));
  stranger.open("tims/" + test_fleet(), partition_of(a));
  ASSERT_TRUE(until([&] { return stranger.is_matched(); }, "the router reaches a"));
  // It had as much time.
  EXPECT_FALSE(other.is_matched());
  EXPECT_TRUE(until([&] { return a.seen.size() >= 2; }, "a sees b and the router"));
  EXPECT_EQ(a.seen.size(), 2);
}

TEST_F(DdsEngineTest, WhatIsForNobodyIsGivenUp) {
  Host a(loop_, "a");
  ASSERT_TRUE(a.start());
  // It never makes a reader.
  const auto announcement = announcement_of("silent", test_fleet());
  ForeignParticipant silent(test_domain(), ForeignParticipant::router(announcement));
  ASSERT_TRUE(until([&] { return a.is_up() && a.seen.size() == 1; }, "a sees it"));
  a.engine.connect(a.seen[0].dds);
  ASSERT_TRUE(a.send(a.seen[0].dds, Bytes(25), 10));
  EXPECT_GT(a.engine.counters().waiting_bytes, 25);
  ASSERT_TRUE(until([&] { return a.engine.counters().unmatched == 3; }, "all are given up"));
  EXPECT_EQ(a.engine.counters().waiting_bytes, 0);
}

// --- killed

// Not a test: a router in a process of its own.
TEST_F(DdsEngineTest, DISABLED_Actor) {
  const char* domain =
      ::getenv("DDS_TEST_DOMAIN");  // NOLINT(concurrency-mt-unsafe): no thread sets it
  const char* fleet =
      ::getenv("DDS_TEST_FLEET");  // NOLINT(concurrency-mt-unsafe): no thread sets it
  ASSERT_TRUE(domain != nullptr && fleet != nullptr);
  Host actor(loop_, "actor",
             {.fleet = fleet, .domain = static_cast<unsigned>(std::stoul(domain)), .lease = 3s});
  ASSERT_TRUE(actor.start());
  (void)run_until(
      loop_, [] { return false; }, "to be killed", 5 * test::kPatience);
}

Result<test::ChildProcess> start_actor() {
  const test::ChildOptions where{
      {"DDS_TEST_DOMAIN=" + std::to_string(test_domain()), "DDS_TEST_FLEET=" + test_fleet()}, {}};
  return test::ChildProcess::start({"/proc/self/exe", "--gtest_also_run_disabled_tests",
                                    "--gtest_filter=DdsEngineTest.DISABLED_Actor"},
                                   where);
}

// UDP, of this network namespace.
std::uint64_t packets_out() {
  std::ifstream statistics("/proc/thread-self/net/snmp");
  std::string name;
  std::uint64_t in = 0;
  std::uint64_t no_port = 0;
  std::uint64_t errors = 0;
  std::uint64_t out = 0;
  while (statistics >> name) {
    if (name == "Udp:" && statistics >> in >> no_port >> errors >> out) return out;
    statistics.clear();
  }
  return 0;
}

// The library detects it; data written when it crashes may restart the lease.
TEST_F(DdsEngineTest, ARouterThatIsKilledIsGoneWithinItsLease) {
  constexpr Duration kLease = 3s;
  Host a(loop_, "a", {.lease = kLease});
  ASSERT_TRUE(a.start());
  auto actor = start_actor();
  ASSERT_TRUE(actor) << actor.error().message();
  ASSERT_TRUE(until([&] { return a.seen.size() == 1; }, "a sees the actor"));
  EXPECT_EQ(a.seen[0].identity.name.view(), "actor");
  ASSERT_TRUE(a.send(a.seen[0].dds, Bytes(100), 100));
  ASSERT_TRUE(until([&] { return a.engine.counters().samples_out == 1; }, "it is written"));
  ASSERT_TRUE(actor->stop(SIGKILL));
  ASSERT_TRUE(run_until(
      loop_, [&] { return !a.gone.empty(); }, "a notices", 2 * kLease * test::kSlowdown));
  EXPECT_TRUE(a.seen.empty());
}

TEST_F(DdsEngineTest, SilentPeersAreAskedLessOften) {
  constexpr int kSamples = 30;  // a history takes them
  constexpr auto kPeriod = 20ms;
  auto network = test::OwnNetwork::enter();
  if (!network) GTEST_SKIP() << network.error().message();
  Host a(loop_, "a", {.lease = 60s});
  ASSERT_TRUE(a.start());
  auto actor = start_actor();
  ASSERT_TRUE(actor) << actor.error().message();
  ASSERT_TRUE(until([&] { return a.seen.size() == 1; }, "a sees the actor"));
  ASSERT_TRUE(a.send(a.seen[0].dds, Bytes(10), 10));
  ASSERT_TRUE(until([&] { return a.engine.counters().samples_out == 1; }, "it is written"));
  actor->signal(SIGSTOP);
  const std::uint64_t before = packets_out();
  const Time began = os::now();
  for (int i = 0; i < kSamples; ++i) {
    ASSERT_TRUE(a.send(a.seen[0].dds, Bytes(10), 10));
    const Time next = os::now() + kPeriod;
    ASSERT_TRUE(until([&] { return os::now() >= next; }, "a while"));
  }
  EXPECT_EQ(a.engine.counters().samples_out, kSamples + 1);
  // The rest is discovery, and some 15 heartbeats: in proportion to the time.
  const auto periods = static_cast<std::uint64_t>((os::now() - began) / kPeriod);
  EXPECT_LT(packets_out() - before, kSamples + periods);
}

TEST(DdsTransport, AsksAllReadersForNoSampleToOne) {
  const DdsTransport transport(
      std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>(), nullptr, nullptr);
  EXPECT_GE(transport.min_send_buffer_size(), 1U << 30);
}

TEST(DdsRoute, PausesAreTwiceAsLongEachTime) {
  EXPECT_EQ(DdsRoute::pause({}, 2ms), 2ms);
  EXPECT_EQ(DdsRoute::pause(10ms, 2ms), 10ms);
  EXPECT_EQ(DdsRoute::pause(10s, 2ms), 250ms);
  EXPECT_EQ(DdsRoute::pause(10s, 300ms), 300ms) << "as configured";
}

// --- without multicast

TEST_F(DdsEngineTest, OnePeerInTheListIsEnough) {
  Host a(loop_, "a", {.multicast = false});
  Host b(loop_, "b", {.multicast = false, .peers = {"127.0.0.1"}});
  meet(a, b);
  ASSERT_TRUE(a.send(b.address(), Bytes(10), 10));
  ASSERT_TRUE(b.send(a.address(), Bytes(10), 10));
  EXPECT_TRUE(until([&] { return a.arrivals.size() == 1 && b.arrivals.size() == 1; }, "both"));
}

TEST_F(DdsEngineTest, APeerIsFoundAfterManyRestarts) {
  Host a(loop_, "a", {.multicast = false});
  Host b(loop_, "b", {.multicast = false, .peers = {"127.0.0.1"}});
  ASSERT_TRUE(a.start());
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(until([&] { return a.is_up(); }, "it is up"));
    a.engine.restart(a.self);
  }
  ASSERT_TRUE(b.start());
  EXPECT_TRUE(until([&] { return a.is_up() && b.is_up() && a.sees(b) && b.sees(a); }, "they meet"));
}

// The port is one that another test's server would not have.
std::uint16_t server_port() { return static_cast<std::uint16_t>(20'000 + ::getpid() % 20'000); }

TEST_F(DdsEngineTest, AfterDiscoveryTheDiscoveryServerMayGo) {
  const DdsSettings by_server{.multicast = false,
                              .discovery_server = "127.0.0.1:" + std::to_string(server_port())};
  auto server = std::make_unique<ForeignParticipant>(test_domain(),
                                                     ForeignParticipant::server(server_port()));
  Host a(loop_, "a", by_server);
  Host b(loop_, "b", by_server);
  meet(a, b);
  ASSERT_TRUE(a.send(b.address(), Bytes(10), 10));
  ASSERT_TRUE(b.send(a.address(), Bytes(10), 10));
  ASSERT_TRUE(until([&] { return a.arrivals.size() == 1 && b.arrivals.size() == 1; }, "both"));
  server.reset();
  Host late(loop_, "late", by_server);
  ASSERT_TRUE(late.start());
  ASSERT_TRUE(until([&] { return late.is_up(); }, "the late one is up"));
  // Routers that have communicated do not need the server.
  ASSERT_TRUE(b.send(a.address(), Bytes(10), 10));
  ASSERT_TRUE(until([&] { return a.arrivals.size() == 2; }, "it arrives"));
  server = std::make_unique<ForeignParticipant>(test_domain(),
                                                ForeignParticipant::server(server_port()));
  EXPECT_TRUE(until([&] { return late.sees(a) && late.sees(b) && a.sees(late) && b.sees(late); },
                    "all see the late one"));
  ASSERT_TRUE(late.send(a.address(), Bytes(10), 10));
  EXPECT_TRUE(until([&] { return a.arrivals.size() == 3; }, "it arrives"));
}

// --- profiles

std::string profiles(const std::string& name) {
  return R"(<?xml version="1.0" encoding="UTF-8" ?>
<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles"><profiles>
  <participant profile_name=")" +
         name + R"("><rtps><builtin><discovery_config>
    <leaseDuration><sec>7</sec></leaseDuration>
  </discovery_config></builtin></rtps></participant>
  <data_writer profile_name=")" +
         name + R"("><qos><publishMode><kind>ASYNCHRONOUS</kind></publishMode></qos></data_writer>
</profiles></dds>)";
}

std::string profiles_with_transport(const std::string& type) {
  return R"(<?xml version="1.0" encoding="UTF-8" ?>
<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles"><profiles>
  <transport_descriptors><transport_descriptor>
    <transport_id>own</transport_id><type>)" +
         type + R"(</type>
  </transport_descriptor></transport_descriptors>
  <participant profile_name="tims"><rtps>
    <userTransports><transport_id>own</transport_id></userTransports>
    <useBuiltinTransports>false</useBuiltinTransports>
  </rtps></participant>
</profiles></dds>)";
}

class DdsProfiles : public DdsEngineTest {
 protected:
  std::string write(const std::string& text) {
    const auto path = folder_.path() / "dds.xml";
    std::ofstream(path) << text;
    return path;
  }
  test::TemporaryFolder folder_;
};

TEST_F(DdsProfiles, AreRead) {
  const std::string file = write(profiles("tims"));
  Host a(loop_, "a", {.profiles = file});
  Host b(loop_, "b", {.profiles = file});
  meet(a, b);
  ASSERT_TRUE(a.send(b.address(), Bytes(10), 10));
  EXPECT_TRUE(until([&] { return b.arrivals.size() == 1; }, "it arrives"));
}

TEST_F(DdsProfiles, MayHaveATransportOfTheirOwn) {
  const std::string file = write(profiles_with_transport("UDPv4"));
  Host a(loop_, "a", {.profiles = file});
  Host b(loop_, "b");
  meet(a, b);
  ASSERT_TRUE(a.send(b.address(), Bytes(60'000), 1200));
  ASSERT_TRUE(b.send(a.address(), Bytes(60'000), 1200));
  EXPECT_TRUE(until([&] { return b.bytes_in == 60'000 && a.bytes_in == 60'000; }, "all arrive"));
}

TEST_F(DdsProfiles, ButNotOneThatWaits) {
  Host a(loop_, "a", {.profiles = write(profiles_with_transport("TCPv4"))});
  const auto started = a.start();
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().message(), HasSubstr("dds.xml: TCP is not a transport for routers"));
}

TEST_F(DdsProfiles, WithoutOneForUs) {
  Host a(loop_, "a", {.profiles = write(profiles("somebody"))});
  const auto started = a.start();
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().message(), HasSubstr("no participant profile \"tims\""));
}

TEST_F(DdsProfiles, ThatAreNone) {
  Host a(loop_, "a", {.profiles = write("<dds><profiles><participant")});
  const auto started = a.start();
  ASSERT_FALSE(started);
  EXPECT_THAT(started.error().message(), HasSubstr("dds.xml is not a file of Fast DDS profiles"));
}

}  // namespace dds_engine_test

// Discovery of routers, of foreign participants, and of their departure.

}  // namespace tims::io

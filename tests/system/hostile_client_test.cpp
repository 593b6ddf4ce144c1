// A program on this host that violates the local protocol is disconnected, and other clients are
// not affected.
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include "os/shared_memory.h"
#include "os/socket.h"
#include "os/wakeup.h"
#include "shm/layout.h"
#include "shm/receiver.h"
#include "shm/sender.h"
#include "tests/support/child_process.h"
#include "tests/support/eventually.h"
#include "tests/support/router_process.h"
#include "tests/support/tcp_client.h"
#include "tests/system/raw_client.h"
#include "tims/session.h"
#include "wire/header.h"
#include "wire/local_protocol.h"

namespace tims::test {
namespace hostile_client_test {

using namespace std::chrono_literals;

class HostileClientTest : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(router_.start().ok()); }
  void TearDown() override {
    // The router still serves other clients.
    auto session = Session::connect({.router = router_.socket_path(), .timeout = kPatience});
    ASSERT_TRUE(session.ok());
    auto mailbox = session->open({.address = Address(0x7F000001)});
    ASSERT_TRUE(mailbox.ok());
    auto tcp = TcpClient::connect(router_.tcp());
    ASSERT_TRUE(tcp.ok());
    ASSERT_TRUE(tcp->send({.type = 21, .dest = mailbox->address(), .src = Address(3)}).ok());
    EXPECT_TRUE(mailbox->peek_for(kPatience).ok());
  }

  RouterProcess router_;
};

TEST_F(HostileClientTest, MessagesBeforeHello) {
  RawClient client(router_.socket_path());
  client.send(wire::Lookup{{Address(1)}});
  EXPECT_TRUE(client.thrown_out());
}

TEST_F(HostileClientTest, OtherVersionsGetARefusalWithAnAdvice) {
  RawClient client(router_.socket_path());
  client.send(
      wire::Hello{.version_min = wire::kLocalVersion + 1, .version_max = 9, .name = "future"});
  const auto answer = client.receive();
  ASSERT_TRUE(answer && std::holds_alternative<wire::Refused>(*answer));
  const std::string ours = "version " + std::to_string(wire::kLocalVersion);
  EXPECT_NE(std::get<wire::Refused>(*answer).text.find(ours), std::string::npos);
  EXPECT_TRUE(client.thrown_out());
}

TEST_F(HostileClientTest, Garbage) {
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    RawClient client(router_.socket_path());
    if (round % 2 == 0) {
      ASSERT_TRUE(client.hello());
    }
    std::vector<std::byte> bytes(1 + random() % 300);
    for (std::byte& b : bytes) b = static_cast<std::byte>(random());
    client.send_bytes(bytes);
  }
}

TEST_F(HostileClientTest, MessagesThatOnlyRoutersSend) {
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello());
  client.send(wire::Welcome{});
  EXPECT_TRUE(client.thrown_out());
}

TEST_F(HostileClientTest, MemoryThatCouldShrinkIsRefused) {
  const os::File memfd(::memfd_create("unsealed", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  ASSERT_EQ(::ftruncate(memfd.get(), 65536), 0);
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello());
  EXPECT_EQ(try_open(client, memfd, 0), wire::OpenStatus::kBadPlace);
}

TEST_F(HostileClientTest, MemoryWithoutAMailboxIsRefused) {
  for (const std::uint64_t offset : {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{4096},
                                     std::uint64_t{1} << 40, ~std::uint64_t{127}}) {
    const os::File memfd = std::move(*os::make_memfd("zeros", 4096));
    RawClient client(router_.socket_path());
    ASSERT_TRUE(client.hello());
    EXPECT_EQ(try_open(client, memfd, offset), wire::OpenStatus::kBadPlace) << offset;
  }
  const os::File not_memory(::open("/dev/null", O_RDWR | O_CLOEXEC));
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello());
  EXPECT_EQ(try_open(client, not_memory, 0), wire::OpenStatus::kBadPlace);
}

TEST_F(HostileClientTest, AnOwnerThatCorruptsItsMailboxHarmsOnlyItself) {
  const std::size_t bytes = shm::Geometry::of(4, 80).bytes;
  const os::File memfd = std::move(*os::make_memfd("scribble", bytes));
  const os::Mapping mapping = std::move(*os::Mapping::of(memfd));
  shm::MailboxView::create(mapping.bytes(), 0,
                           {.address = Address(5), .slots = 4, .message_max = 80});
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello());
  ASSERT_EQ(try_open(client, memfd, 0), wire::OpenStatus::kOk);
  auto tcp = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(tcp.ok());
  std::mt19937 random(3);
  for (int round = 0; round < 300; ++round) {
    for (std::byte& b : mapping.bytes())
      if (random() % 4 == 0) b = static_cast<std::byte>(random());
    if (round % 3 == 0) std::memset(mapping.bytes().data(), round, mapping.bytes().size());
    ASSERT_TRUE(tcp->send({.type = -6, .dest = Address(5), .src = Address(3)}).ok());
  }
  ::fallocate(memfd.get(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0,
              static_cast<off_t>(bytes));
  ASSERT_TRUE(tcp->send({.type = -6, .dest = Address(5), .src = Address(3)}).ok());
}

// Descriptors whose buffers are full: a blocking write to them does not return.
struct Trap {
  std::string kind;
  os::File in;
  os::File out;  // kept open, so that the write waits for a reader
};
Trap full(std::string kind, std::array<int, 2> ends) {
  Trap trap{std::move(kind), os::File(ends[1]), os::File(ends[0])};
  std::array<std::byte, 4096> much{};
  ::fcntl(trap.in.get(), F_SETFL, O_NONBLOCK);
  while (::write(trap.in.get(), much.data(), much.size()) > 0) {
  }
  while (::write(trap.in.get(), much.data(), 1) > 0) {
  }
  ::fcntl(trap.in.get(), F_SETFL, 0);
  return trap;
}
std::vector<Trap> traps() {
  std::vector<Trap> all;
  os::File event(::eventfd(0, EFD_CLOEXEC));
  ::eventfd_write(event.get(), ~eventfd_t{0} - 1);
  all.push_back({"eventfd", std::move(event), {}});
  std::array<int, 2> ends{};
  for (const auto& [kind, type] :
       {std::pair{"datagrams", SOCK_DGRAM}, {"records", SOCK_SEQPACKET}, {"stream", SOCK_STREAM}})
    if (::socketpair(AF_UNIX, type | SOCK_CLOEXEC, 0, ends.data()) == 0)
      all.push_back(full(kind, ends));
  if (::pipe2(ends.data(), O_CLOEXEC) == 0) all.push_back(full("pipe", ends));
  return all;
}

// No sender waits for the owner of a mailbox, whatever descriptor the owner chose for its wake-up.
TEST_F(HostileClientTest, AnOwnerWhoseWakeUpDescriptorIsFull) {
  auto tcp = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(tcp.ok());
  auto session = Session::connect({.router = router_.socket_path(), .timeout = kPatience});
  ASSERT_TRUE(session.ok());
  auto neighbour = session->open({.address = Address(6)});
  ASSERT_TRUE(neighbour.ok());
  for (const Trap& trap : traps()) {
    const std::size_t bytes = shm::Geometry::of(4, 80).bytes;
    const os::File memfd = std::move(*os::make_memfd("trap", bytes));
    const os::Mapping mapping = std::move(*os::Mapping::of(memfd));
    auto view = shm::MailboxView::create(
        mapping.bytes(), 0,
        {.address = Address(5), .slots = 4, .message_max = 80, .wake = shm::WakeKind::kSocket});
    RawClient client(router_.socket_path());
    ASSERT_TRUE(client.hello());
    const auto opened = try_open(client, memfd, 0, trap.in);
    if (trap.kind != "datagrams") {
      EXPECT_EQ(opened, wire::OpenStatus::kBadPlace) << trap.kind;
      continue;
    }
    EXPECT_EQ(opened, wire::OpenStatus::kOk);
    const auto sleep = [&] { view.header().sleep.store(1, std::memory_order_seq_cst); };
    sleep();
    ASSERT_TRUE(tcp->send({.type = -6, .dest = Address(5), .src = Address(3)}).ok());
    EXPECT_TRUE(eventually([&] { return shm::waiting(view) == 1; }, "the router's message"));
    ASSERT_TRUE(client.send(wire::Lookup{{Address(5)}}));
    ASSERT_TRUE(client.receive().has_value()) << "the router is blocked";
    // The memory has changed by the time another client reads it.
    view.header().wake = shm::WakeKind::kDoorbell;
    sleep();
    EXPECT_TRUE(neighbour->send({.dest = Address(5), .type = -7}).ok());
    EXPECT_EQ(shm::waiting(view), 2U);
  }
}

TEST_F(HostileClientTest, AClientThatCorruptsItsUplink) {
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello_and_uplink());
  const os::Mapping mapping = std::move(*os::Mapping::of(client.files()[0]));
  const os::File doorbell = std::move(client.files()[1]);
  std::mt19937 random(5);
  for (int round = 0; round < 300; ++round) {
    const std::span<std::byte> head = mapping.bytes().first(16384);
    for (std::byte& b : head)
      if (random() % 8 == 0) b = static_cast<std::byte>(random());
    os::signal_event_fd(doorbell.get());
    if (!client.send(wire::Lookup{{Address(5)}}) || !client.receive())
      break;  // the router is awake
  }
}

// The owner of a closed mailbox need not wait. The router, as owner of the uplink, must wait
// nevertheless.
TEST_F(HostileClientTest, AClientThatClosesItsUplink) {
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello_and_uplink());
  const os::Mapping mapping = std::move(*os::Mapping::of(client.files()[0]));
  const os::File doorbell = std::move(client.files()[1]);
  shm::MailboxView::open(mapping.bytes(), 0)->header().closed.store(1U, std::memory_order_release);
  os::signal_event_fd(doorbell.get());
  // It counts as asleep if it is found asleep several times in succession.
  int asleep = 0;
  EXPECT_TRUE(eventually(
      [&] {
        asleep = state_of(router_.process().pid()) == 'S' ? asleep + 1 : 0;
        return asleep == 20;
      },
      "the router sleeps"));
}

// It sets the flag in its memory repeatedly, while the router reports the mailbox as open.
TEST_F(HostileClientTest, AnOwnerThatClosesAgainAndAgain) {
  const os::File memfd = std::move(*os::make_memfd("closing", shm::Geometry::of(4, 80).bytes));
  const os::Mapping mapping = std::move(*os::Mapping::of(memfd));
  const auto view = shm::MailboxView::create(
      mapping.bytes(), 0, {.address = Address(5), .slots = 4, .message_max = 80});
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello());
  ASSERT_EQ(try_open(client, memfd, 0), wire::OpenStatus::kOk);
  auto session = Session::connect({.router = router_.socket_path(), .timeout = kPatience});
  ASSERT_TRUE(session.ok());
  auto sender = session->open({.address = Address(6)});
  ASSERT_TRUE(sender.ok());
  ASSERT_TRUE(sender->send({.dest = Address(5)}).ok());
  const std::size_t mappings = mappings_of(::getpid());
  for (int round = 0; round < 500; ++round) {
    view.header().closed.store(1, std::memory_order_release);
    EXPECT_EQ(sender->send({.dest = Address(5)}).error().code(), Errc::kNoMailbox);
    view.header().closed.store(0, std::memory_order_release);
    ASSERT_TRUE(sender->send({.dest = Address(5)}).ok());
  }
  EXPECT_LT(mappings_of(::getpid()), mappings + 100);
}

// An owner sleeps, whatever its senders write into its mailbox.
TEST_F(HostileClientTest, ASenderThatClosesTheMailbox) {
  auto victim = ChildProcess::start({TIMS_ACTOR_PROGRAM, "echo", router_.socket_path(), "5"});
  ASSERT_TRUE(victim.ok());
  ASSERT_TRUE(victim->wait_for_line("ready").ok());
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello());
  ASSERT_TRUE(client.send(wire::Lookup{{Address(5)}}) && client.receive());
  ASSERT_EQ(client.files().size(), 1U);
  const os::Mapping mapping = std::move(*os::Mapping::of(client.files()[0]));
  const auto view = *shm::MailboxView::open(mapping.bytes(), 0);
  view.header().closed.store(1U, std::memory_order_release);
  os::futex_clear_and_wake(*view.header().sleep.raw());
  int asleep = 0;
  EXPECT_TRUE(eventually(
      [&] {
        asleep = state_of(victim->pid()) == 'S' ? asleep + 1 : 0;
        return asleep == 20;
      },
      "the owner sleeps"));
}

// Descriptors are limited per client, so that one client cannot use those of the others.
TEST_F(HostileClientTest, AClientThatOffersMemoryAndOpensNothing) {
  const os::File memfd = std::move(*os::make_memfd("offered", 4096));
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello());
  const std::size_t before = descriptors_of(router_.process().pid());
  for (std::uint64_t segment = 1; segment <= 16; ++segment)
    client.send(wire::OfferSegment{segment}, {memfd.get()});
  ASSERT_TRUE(client.send(wire::Lookup{{Address(5)}}) && client.receive()) << "sixteen are allowed";
  client.send(wire::OfferSegment{17}, {memfd.get()});
  EXPECT_TRUE(client.thrown_out());
  EXPECT_TRUE(eventually([&] { return descriptors_of(router_.process().pid()) < before; },
                         "its descriptors are free"));
}

// The flags of a shared descriptor are shared, so the router's read must not depend on O_NONBLOCK.
TEST_F(HostileClientTest, AClientThatEmptiesItsDoorbellBeforeTheRouterDoes) {
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello_and_uplink());
  const os::File doorbell = std::move(client.files()[1]);
  ::fcntl(doorbell.get(), F_SETFL, 0);
  for (int round = 0; round < 1000; ++round) {
    os::signal_event_fd(doorbell.get());
    os::drain_event_fd(doorbell.get());
    ASSERT_TRUE(client.send(wire::Lookup{{Address(5)}}));
    ASSERT_TRUE(client.receive().has_value()) << "round " << round;
  }
}

TEST_F(HostileClientTest, ForgedSourcesFromThisHostAreDropped) {
  auto session = Session::connect({.router = router_.socket_path(), .timeout = kPatience});
  ASSERT_TRUE(session.ok());
  auto tcp = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(tcp.ok());
  ASSERT_TRUE(tcp->register_mailbox(Address(9)).ok());
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello_and_uplink());
  const os::Mapping mapping = std::move(*os::Mapping::of(client.files().front()));
  shm::Sender sender(*shm::MailboxView::open(mapping.bytes(), 0), 77);
  shm::Claim claim;
  ASSERT_TRUE(shm::taken(sender.claim(16, 0, claim)));
  const Header forged{.type = -6, .dest = Address(9), .src = Address(1234)};
  wire::encode_header(forged, wire::HeaderBytes(claim.header, kHeaderSize));
  ASSERT_EQ(sender.commit(claim), shm::SendOutcome::kOk);
  os::signal_event_fd(client.files()[1].get());
  // Then a valid message, after the forged one.
  auto mailbox = session->open({.address = Address(8)});
  ASSERT_TRUE(mailbox.ok());
  ASSERT_TRUE(mailbox->send({.dest = Address(9), .type = -7}).ok());
  const auto got = tcp->receive();
  ASSERT_TRUE(got.ok());
  EXPECT_EQ(got->header.type, -7);
}

// As a fast sender does whose receiver has come to this host meanwhile.
TEST_F(HostileClientTest, ASenderIsToldOnceToLookAnAddressUpAgain) {
  constexpr int kMessages = 5000;  // more than its socket takes
  const Address receiver(8);
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello_and_uplink());
  const os::Mapping uplink = std::move(*os::Mapping::of(client.files().front()));
  const os::File doorbell = std::move(client.files()[1]);
  const os::File memfd = std::move(*os::make_memfd("own", shm::Geometry::of(4, 80).bytes));
  const os::Mapping own = std::move(*os::Mapping::of(memfd));
  shm::MailboxView::create(own.bytes(), 0, {.address = Address(5), .slots = 4, .message_max = 80});
  ASSERT_EQ(try_open(client, memfd, 0), wire::OpenStatus::kOk);
  auto session = Session::connect({.router = router_.socket_path(), .timeout = kPatience});
  ASSERT_TRUE(session.ok());
  auto mailbox = session->open({.address = receiver});
  ASSERT_TRUE(mailbox.ok());

  shm::Sender sender(*shm::MailboxView::open(uplink.bytes(), 0), 77);
  const auto send = [&] {
    shm::Claim claim;
    ASSERT_TRUE(shm::taken(sender.claim(16, 0, claim)));
    const Header header{.type = 21, .dest = receiver, .src = Address(5)};
    wire::encode_header(header, wire::HeaderBytes(claim.header, kHeaderSize));
    ASSERT_EQ(sender.commit(claim), shm::SendOutcome::kOk);
    os::signal_event_fd(doorbell.get());
    ASSERT_TRUE(mailbox->peek_for(kPatience).ok()) << "the router is gone, or the client";
  };
  const auto moved_before_found = [&] {
    int moved = 0;
    EXPECT_TRUE(client.send(wire::Lookup{{receiver}}));
    for (;;) {
      const auto record = client.receive();
      if (!record || !std::holds_alternative<wire::Moved>(*record)) {
        EXPECT_TRUE(record && std::get<wire::Found>(*record).local);
        return moved;
      }
      EXPECT_EQ(std::get<wire::Moved>(*record).address, receiver);
      ++moved;
    }
  };
  for (int i = 0; i < kMessages && !HasFatalFailure(); ++i) send();
  EXPECT_EQ(moved_before_found(), 1);
  EXPECT_EQ(moved_before_found(), 0);
  send();
  EXPECT_EQ(moved_before_found(), 1) << "it went on as before, so it is told again";
}

TEST_F(HostileClientTest, AClientThatAsksAndNeverReads) {
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello());
  const std::vector<Address> many(wire::kBatchMax, Address(1));
  for (int i = 0; i < 1000; ++i)
    if (!client.send(wire::Lookup{many})) return;  // disconnected
  FAIL() << "still connected after a million questions";
}

TEST_F(HostileClientTest, TenThousandConnections) {
  for (int i = 0; i < 10000; ++i) {
    RawClient client(router_.socket_path());
    if (i % 3 == 0) {
      ASSERT_TRUE(client.hello());
    }
  }
}

}  // namespace hostile_client_test
}  // namespace tims::test

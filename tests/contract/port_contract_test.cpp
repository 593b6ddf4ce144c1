// Requirements of every port of the router, for clients on shared memory, TCP or WebSocket, and
// behind a link. The other side is always a client on TCP, called the witness.
#include <algorithm>
#include <csignal>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <boost/json.hpp>
#include <gtest/gtest.h>

#include "tests/contract/guest.h"
#include "tests/support/child_process.h"
#include "tests/support/eventually.h"
#include "tests/support/router_process.h"
#include "tests/support/tcp_client.h"

namespace tims::test {
namespace port_contract_test {

enum class Kind : std::uint8_t { kSharedMemory, kTcp, kWebSocket, kLink };

constexpr Address kGuest{0x01140000};
constexpr Address kOtherGuest{0x01140001};
constexpr Address kWitness{0x00150000};
constexpr Address kBystander{0x00160000};
constexpr Address kNobody{0x01170000};

// A body that contains its number and a pattern that shows whether it is complete.
std::vector<std::byte> numbered(std::uint32_t number, std::size_t size) {
  std::vector<std::byte> body(size);
  for (std::size_t i = 0; i < size; ++i) body[i] = static_cast<std::byte>(number >> 8 * (i % 4));
  return body;
}

std::optional<std::uint32_t> number_of(const std::vector<std::byte>& body) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < 4; ++i) number |= std::to_integer<std::uint32_t>(body[i]) << 8 * i;
  return body == numbered(number, body.size()) ? std::optional(number) : std::nullopt;
}

class PortContract : public testing::TestWithParam<Kind> {
 protected:
  void SetUp() override {
    start(router_, {"router.role=top", "router.name=base", "http.listen=127.0.0.1:0",
                    "link=kind=sub,system=*"});
    if (GetParam() == Kind::kLink) {
      start(below_, {"router.role=system", "router.system=1", "router.name=robot",
                     "link=kind=super,to=" + udp_of(*router_)});
    }
    witness_.emplace(tcp(kWitness));
  }

  // The router that guests attach to.
  RouterProcess& near() { return GetParam() == Kind::kLink ? *below_ : *router_; }

  std::unique_ptr<Guest> guest() {
    switch (GetParam()) {
      case Kind::kSharedMemory:
        return local_guest(near().socket_path());
      case Kind::kTcp:
      case Kind::kLink:
        return tcp_guest(near().tcp());
      case Kind::kWebSocket:
        return websocket_guest(near().http());
    }
    return nullptr;
  }
  std::unique_ptr<Guest> guest_at(Address address) {
    auto guest = this->guest();
    EXPECT_TRUE(eventually([&]() -> std::string {
      const auto opened = guest->open(address);
      return opened.ok() ? "" : opened.error().message();
    }));
    EXPECT_TRUE(is_reachable(address));
    return guest;
  }
  // Whether the witness' router knows the address.
  testing::AssertionResult is_reachable(Address address, bool wanted = true) {
    const std::string question = R"({"ask":"route","to":")" + address.to_hex() + R"("})";
    return eventually([&]() -> std::string {
      const auto answer = ask(*router_, question);
      const bool found = answer.at("verdict") != "no_route";
      return found == wanted ? "" : boost::json::serialize(answer);
    });
  }

  TcpClient tcp(Address mailbox) {
    auto client = TcpClient::connect(router_->tcp());
    EXPECT_TRUE(client.ok()) << client.error().message();
    EXPECT_TRUE(client->register_mailbox(mailbox).ok());
    return std::move(*client);
  }
  void witness_sends(const Header& header, const std::vector<std::byte>& body) {
    Header complete = header;
    complete.src = kWitness;
    const auto sent = witness_->send(complete, body);
    ASSERT_TRUE(sent.ok()) << sent.error().message();
  }

  static boost::json::object ask(RouterProcess& router, std::string_view question) {
    auto client = TcpClient::connect(router.tcp());
    EXPECT_TRUE(client.ok() &&
                client->send({.type = type::kAdminRequest}, bytes_of(question)).ok());
    const auto answer = client->receive();
    if (!answer) return {{"error", answer.error().message()}};
    return boost::json::parse(
               {reinterpret_cast<const char*>(answer->body.data()), answer->body.size()})
        .as_object();
  }
  // The number of messages counted with this outcome; by default, with any outcome that is a loss.
  std::uint64_t counted(std::string_view outcome = {}) {
    std::uint64_t messages = 0;
    for (RouterProcess* router : {router_ ? &*router_ : nullptr, below_ ? &*below_ : nullptr}) {
      if (router == nullptr) continue;
      const auto stats = ask(*router, R"({"ask":"stats"})");
      for (const auto& item : stats.at("items").as_array()) {
        const bool counts = outcome.empty() ? item.at("dropped").as_bool()
                                            : item.at("outcome").as_string() == outcome;
        if (counts) messages += item.at("messages").to_number<std::uint64_t>();
      }
    }
    return messages;
  }

  std::optional<RouterProcess> router_;
  std::optional<RouterProcess> below_;  // connected by a link
  std::optional<TcpClient> witness_;

 private:
  static void start(std::optional<RouterProcess>& router, std::vector<std::string> settings) {
    settings.insert(settings.end(), {"message.max=64KiB", "tcp.queue=1MiB",
                                     "udp.listen=127.0.0.1:0", "lifesign.interval=1h"});
    router.emplace(std::move(settings));
    const auto started = router->start();
    ASSERT_TRUE(started.ok()) << started.error().message();
  }
  static std::string udp_of(RouterProcess& router) {
    const auto line = router.process().wait_for_line("listening udp");
    EXPECT_TRUE(line.ok()) << line.error().message();
    return line->substr(line->rfind(' ') + 1);
  }
};

TEST_P(PortContract, MessagesOfAnySizeArriveCompleteInBothDirections) {
  const auto guest = guest_at(kGuest);
  std::uint8_t number = 0;
  for (const std::size_t size : {0U, 1U, 15U, 16U, 17U, 1199U, 1200U, 4095U, 4096U, 4097U, 9000U,
                                 kGuestBodyMax - 1, kGuestBodyMax}) {
    const auto body = numbered(0x01020304, size);
    const Header header{.type = 21, .priority = 9, .seq_nr = ++number, .dest = kGuest};
    witness_sends(header, body);
    const auto there = guest->receive();
    ASSERT_TRUE(there.ok()) << size << ": " << there.error().message();
    EXPECT_EQ(there->body, body) << size;
    EXPECT_EQ(there->header.seq_nr, number);
    EXPECT_EQ(there->header.priority, 9);
    EXPECT_EQ(there->header.src, kWitness);
    ASSERT_TRUE(guest->send({.type = -6, .seq_nr = number, .dest = kWitness, .src = kGuest}, body));
    const auto back = witness_->receive();
    ASSERT_TRUE(back.ok()) << size << ": " << back.error().message();
    EXPECT_EQ(back->body, body) << size;
    EXPECT_EQ(back->header.src, kGuest);
  }
}

TEST_P(PortContract, OneSendersMessagesStayInOrder) {
  const auto guest = guest_at(kGuest);
  constexpr std::uint32_t kCount = 500;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    witness_sends({.type = -6, .dest = kGuest}, numbered(i, 40));
    ASSERT_TRUE(guest->send({.type = -6, .dest = kWitness, .src = kGuest}, numbered(i, 40)).ok());
  }
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const auto there = guest->receive();
    ASSERT_TRUE(there.ok()) << there.error().message();
    ASSERT_EQ(number_of(there->body), i);
    const auto back = witness_->receive();
    ASSERT_TRUE(back.ok()) << back.error().message();
    ASSERT_EQ(number_of(back->body), i);
  }
}

TEST_P(PortContract, MessagesSentBeforeClosingArrive) {
  const auto guest = guest_at(kGuest);
  constexpr std::uint32_t kCount = 900;
  for (std::uint32_t i = 0; i < kCount; ++i)
    ASSERT_TRUE(guest->send({.type = -6, .dest = kWitness, .src = kGuest}, numbered(i, 40)).ok());
  guest->close();
  for (std::uint32_t i = 0; i < kCount; ++i) {
    const auto message = witness_->receive();
    ASSERT_TRUE(message.ok()) << "number " << i << ": " << message.error().message();
    ASSERT_EQ(number_of(message->body), i);
  }
}

TEST_P(PortContract, ACommandWithoutReceiverIsAnsweredAndDataIsCounted) {
  const auto guest = guest_at(kGuest);
  ASSERT_TRUE(guest->send({.type = -6, .dest = kNobody, .src = kGuest}, {}).ok());
  ASSERT_TRUE(
      guest->send({.type = 21, .priority = 3, .seq_nr = 7, .dest = kNobody, .src = kGuest}, {})
          .ok());
  const auto answer = guest->receive();
  ASSERT_TRUE(answer.ok()) << answer.error().message();
  EXPECT_EQ(answer->header.type, type::kNotAvailable);
  EXPECT_EQ(answer->header.seq_nr, 7);
  EXPECT_EQ(answer->header.src, kNobody);
  EXPECT_EQ(counted("no_route"), 2U);
}

TEST_P(PortContract, AnAddressHasOneOwner) {
  const auto owner = guest_at(kGuest);
  const auto other = guest();
  EXPECT_EQ(other->open(kGuest).error().code(), Errc::kAddressInUse);
  ASSERT_TRUE(other->open(kOtherGuest).ok());
  witness_sends({.type = 21, .dest = kGuest}, numbered(1, 8));
  EXPECT_TRUE(owner->receive().ok());
}

TEST_P(PortContract, AClientThatReconnectsIsReached) {
  for (std::uint32_t round = 0; round < 5; ++round) {
    const auto guest = guest_at(kGuest);
    witness_sends({.type = 21, .dest = kGuest}, numbered(round, 8));
    const auto message = guest->receive();
    ASSERT_TRUE(message.ok()) << message.error().message();
    EXPECT_EQ(number_of(message->body), round);
    ASSERT_TRUE(
        guest->send({.type = -6, .dest = kWitness, .src = kGuest}, numbered(round, 8)).ok());
    ASSERT_TRUE(witness_->receive().ok());
    guest->close();
    ASSERT_TRUE(is_reachable(kGuest, false));
    witness_sends({.type = 21, .dest = kGuest}, {});
    const auto nobody = witness_->receive();
    ASSERT_TRUE(nobody.ok()) << nobody.error().message();
    EXPECT_EQ(nobody->header.type, type::kNotAvailable);
  }
}

// --- A client that does not read

class StalledReader : public PortContract {
 protected:
  static constexpr std::size_t kBody = 10'000;
  static constexpr std::uint32_t kCount = 4000;  // 40 MB: far more than any queue

  void flood(std::uint8_t priority) {
    for (std::uint32_t i = 0; i < kCount; ++i)
      witness_sends({.type = -6, .priority = priority, .dest = kGuest}, numbered(i, kBody));
    wait_for_router();
  }
  // Waits until the router has processed everything that the witness has sent.
  void wait_for_router() {
    ASSERT_TRUE(witness_->send({.type = type::kAdminRequest}, bytes_of(R"({"ask":"ping"})")).ok());
    const auto answer = witness_->receive();
    ASSERT_TRUE(answer.ok()) << answer.error().message();
    ASSERT_EQ(answer->header.type, type::kAdminReply);
  }
};

TEST_P(StalledReader, BlocksNoOtherClientAndEveryLossIsCounted) {
  const auto guest = guest_at(kGuest);
  TcpClient bystander = tcp(kBystander);
  flood(1);
  witness_sends({.type = 21, .seq_nr = 9, .dest = kBystander}, {});
  ASSERT_TRUE(bystander.receive().ok());
  std::uint32_t received = 0;
  std::optional<std::uint32_t> last;
  const auto take_all = [&] {
    while (const auto message = guest->receive(std::chrono::milliseconds(20))) {
      const auto number = number_of(message->body);
      ASSERT_TRUE(number.has_value()) << "a damaged body";
      ASSERT_TRUE(!last || *number > *last) << *number << " after " << *last;
      last = number;
      ++received;
    }
  };
  EXPECT_TRUE(eventually([&]() -> std::string {
    take_all();
    const std::uint64_t lost = counted();
    return received + lost == kCount
               ? ""
               : std::to_string(received) + " received, " + std::to_string(lost) +
                     " counted as lost, of " + std::to_string(kCount);
  }));
  EXPECT_LT(received, kCount) << "the flood did not exceed the queue";
  // Messages that are already on a link are not replaced by newer ones.
  if (GetParam() != Kind::kLink) {
    EXPECT_EQ(last, kCount - 1) << "the newest message is missing";
  }
}

TEST_P(StalledReader, AnUrgentMessageOvertakesWaitingOnes) {
  const auto guest = guest_at(kGuest);
  const auto neighbour = guest_at(kOtherGuest);
  flood(1);
  witness_sends({.type = 21, .priority = 255, .dest = kGuest}, numbered(kCount, 8));
  // When this message has arrived, the other one is in its queue.
  witness_sends({.type = 21, .priority = 255, .dest = kOtherGuest}, {});
  ASSERT_TRUE(neighbour->receive().ok());
  std::uint32_t newest_before = 0;
  for (;;) {
    const auto message = guest->receive();
    ASSERT_TRUE(message.ok()) << message.error().message();
    if (message->header.type == 21) break;
    newest_before = *number_of(message->body);
  }
  EXPECT_LT(newest_before, kCount - 1) << "the newest came before the urgent one";
}

TEST_P(StalledReader, AMessageOfLowerPriorityReplacesNothing) {
  const auto guest = guest_at(kGuest);
  flood(200);
  witness_sends({.type = -6, .priority = 3, .dest = kGuest}, numbered(kCount, kBody));
  std::optional<std::uint64_t> arrived;
  std::uint64_t received = 0;
  EXPECT_TRUE(eventually(
      [&] {
        while (const auto message = guest->receive(std::chrono::milliseconds(20))) {
          ++received;
          if (number_of(message->body) == kCount) arrived = received;
        }
        return received + counted() == kCount + 1;
      },
      "all accounted for"));
  // It was refused; or it arrived last, if the flood had not reached the queue yet.
  EXPECT_TRUE(!arrived || *arrived == received) << "it arrived before messages of higher priority";
}

// A client that keeps only the newest samples of each stream. Flags of programs at the TCP port
// mean nothing, so the source is a program of this host.
class KeepsNewest : public StalledReader {
 protected:
  void SetUp() override {
    PortContract::SetUp();
    source_ = local_guest(router_->socket_path());
    ASSERT_TRUE(source_->open(kBystander).ok());
    guest_ = guest();
    ASSERT_TRUE(guest_->open_keeping_newest(kGuest).ok());
  }
  void send_sample(std::uint32_t number, std::int8_t type = -6) {
    const Header header{.flags = flag::kStream, .type = type, .priority = 1, .dest = kGuest};
    send(header, numbered(number, kBody - number % 100));
  }
  void send(const Header& header, const std::vector<std::byte>& body) {
    ASSERT_TRUE(eventually([&] { return source_->send(header, body).ok(); }, "room at the router"));
  }
  boost::json::object stream(int type) {
    const auto answer = ask(*router_, R"({"ask":"streams"})");
    for (const auto& item : answer.at("items").as_array())
      if (item.at("type") == type) return item.as_object();
    return {{"samples", 0}, {"dropped", 0}, {"waiting", 0}};
  }

  std::unique_ptr<Guest> source_;
  std::unique_ptr<Guest> guest_;
};

TEST_P(KeepsNewest, OfAStalledStreamOnlyTheNewestSampleWaits) {
  for (std::uint32_t i = 0; i < kCount; ++i) {
    send_sample(i);
    if (i % 100 == 0) send_sample(i, -8);
  }
  send({.type = 22, .priority = 1, .dest = kGuest}, numbered(kCount, 8));
  const auto arrived = [&]() -> std::string {
    const auto counts = stream(-6);
    return counts.at("samples") == kCount ? "" : boost::json::serialize(counts);
  };
  EXPECT_TRUE(eventually(arrived));
  EXPECT_EQ(stream(-6).at("waiting"), 1);
  EXPECT_EQ(stream(-8).at("waiting"), 1);
  std::array<std::uint32_t, 2> received{};
  std::array<std::uint32_t, 2> last{};
  for (;;) {
    const auto message = guest_->receive();
    ASSERT_TRUE(message.ok()) << message.error().message();
    if (message->header.type == 22) break;
    const auto number = number_of(message->body);
    ASSERT_TRUE(number.has_value()) << "a damaged body";
    const std::size_t which = message->header.type == -6 ? 0 : 1;
    EXPECT_TRUE(*number > last[which] || received[which] == 0) << "out of order";
    EXPECT_NE(message->header.flags & flag::kStream, 0);
    last[which] = *number;
    ++received[which];
  }
  EXPECT_EQ(last[0], kCount - 1) << "the newest is missing";
  EXPECT_EQ(last[1], kCount - 100);
  EXPECT_LT(received[0], kCount);
  EXPECT_EQ(stream(-6).at("dropped"), kCount - received[0]);
  EXPECT_EQ(stream(-6).at("waiting"), 0);
  EXPECT_EQ(counted("queue_replaced"), kCount - received[0] + kCount / 100 - received[1]);
}

TEST_P(KeepsNewest, OtherMessagesAreAllKept) {
  constexpr std::uint32_t kFew = 900;
  for (std::uint32_t i = 0; i < 60; ++i) send_sample(i);
  for (std::uint32_t i = 0; i < kFew; ++i)
    send({.type = -6, .priority = 1, .dest = kGuest}, numbered(i, 100));
  for (std::uint32_t i = 0; i < kFew;) {
    const auto message = guest_->receive();
    ASSERT_TRUE(message.ok()) << message.error().message();
    if ((message->header.flags & flag::kStream) != 0) continue;
    ASSERT_EQ(number_of(message->body), i);
    ++i;
  }
}

std::string name_of(const testing::TestParamInfo<Kind>& kind) {
  constexpr std::array kNames{"SharedMemory", "Tcp", "WebSocket", "Link"};
  return kNames.at(static_cast<std::size_t>(kind.param));
}
constexpr std::array kAll{Kind::kSharedMemory, Kind::kTcp, Kind::kWebSocket, Kind::kLink};
INSTANTIATE_TEST_SUITE_P(Ports, PortContract, testing::ValuesIn(kAll), name_of);
INSTANTIATE_TEST_SUITE_P(Ports, StalledReader, testing::ValuesIn(kAll), name_of);
INSTANTIATE_TEST_SUITE_P(Ports, KeepsNewest, testing::Values(Kind::kTcp, Kind::kWebSocket),
                         name_of);

}  // namespace port_contract_test
}  // namespace tims::test

// Rows of the attack list: TLS on plain ports and plain bytes on TLS ports, half handshakes, many
// connections, certificates that are refused; and that all bytes arrive in both directions.
#include "security/relay/tls_relays.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/wakeup.h"
#include "security/crypto/tls_fixture.h"
#include "tests/support/patience.h"

namespace tims::security {
namespace tls_relays_test {

using namespace std::chrono_literals;
using test::kPatience;
using testing::HasSubstr;

std::array<os::File, 2> pair() {
  std::array<int, 2> ends{};
  EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()), 0);
  return {os::File(ends[0]), os::File(ends[1])};
}

bool wait_for(int fd, short events) { return os::is_ready(fd, events, os::now() + kPatience); }

void write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    if (!wait_for(fd, POLLOUT)) FAIL() << "nobody reads";
    const ssize_t n = ::send(fd, text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
  }
}

// Up to `size` bytes, less at the end of the connection.
std::string read_all(int fd, std::size_t size) {
  std::string text;
  std::array<char, 65536> room{};
  while (text.size() < size && wait_for(fd, POLLIN)) {
    const ssize_t n = ::recv(fd, room.data(), std::min(room.size(), size - text.size()), 0);
    if (n <= 0) break;
    text.append(room.data(), static_cast<std::size_t>(n));
  }
  return text;
}

// What becomes of one connection.
struct Outcome {
  os::File event = std::move(*os::make_event_fd());
  std::mutex mutex;
  std::optional<Opened> opened;
  std::string refused;

  void wait() {
    EXPECT_TRUE(os::is_ready(event.get(), POLLIN, os::now() + kPatience));
    const std::lock_guard lock(mutex);  // what the relays' thread has written is seen from here on
  }
  Relayed on(os::File socket, std::optional<TlsContext> tls, bool may_be_plain = false) {
    return {.socket = std::move(socket),
            .tls = std::move(tls),
            .may_be_plain = may_be_plain,
            .on_open =
                [this](Opened what) {
                  const std::lock_guard lock(mutex);
                  opened = std::move(what);
                  os::signal_event_fd(event.get());
                },
            .on_refused =
                [this](const std::string& reason) {
                  const std::lock_guard lock(mutex);
                  refused = reason;
                  os::signal_event_fd(event.get());
                }};
  }
};

class TlsRelaysTest : public testing::Test {
 protected:
  TlsSettings settings(TlsSettings::Side side, const TestPair& own) {
    TlsSettings s;
    s.side = side;
    s.chain = {own.certificate};
    s.key = own.key;
    s.trusted = {root_.certificate};
    return s;
  }
  TlsContext context(TlsSettings::Side side) {
    return TlsContext::make(settings(side, member_)).value();
  }
  // Both ends of a connection by TLS.
  std::array<os::File, 2> connected() {
    auto wire = pair();
    relays_->add(server_.on(std::move(wire[0]), context(TlsSettings::Side::kServer)));
    relays_->add(client_.on(std::move(wire[1]), context(TlsSettings::Side::kClient)));
    server_.wait();
    client_.wait();
    EXPECT_EQ(server_.refused + client_.refused, "");
    return {std::move(server_.opened->socket), std::move(client_.opened->socket)};
  }

  TestPair root_ = test_root("root");
  TestPair member_ = test_member(root_, {"tims://f/top/0/1"});
  Outcome server_;
  Outcome client_;
  std::unique_ptr<TlsRelays> relays_ =
      std::move(*TlsRelays::start());  // ends before what it reports to
};

TEST_F(TlsRelaysTest, BytesArriveInBothDirectionsAndBothSidesAreKnown) {
  const auto [server, client] = connected();
  EXPECT_TRUE(server_.opened->is_tls);
  EXPECT_EQ(server_.opened->chain.front(), member_.certificate);
  std::string much(3 << 20, '?');
  for (std::size_t i = 0; i < much.size(); ++i) much[i] = static_cast<char>(i * 7);
  std::thread writer([&] { write_all(client.get(), much); });
  EXPECT_TRUE(read_all(server.get(), much.size()) == much);
  writer.join();
  write_all(server.get(), "answer");
  EXPECT_EQ(read_all(client.get(), 6), "answer");
}

TEST_F(TlsRelaysTest, WhatWasSentBeforeTheEndArrives) {
  auto [server, client] = connected();
  const std::string last(100'000, 'x');
  std::thread writer([&] {
    write_all(server.get(), last);
    server.reset();
  });
  EXPECT_EQ(read_all(client.get(), last.size() + 1).size(), last.size());
  writer.join();
}

// Whether what it waits for has come.
bool is_called(const TlsRelay& relay) {
  const auto has = [](int socket, short events) {
    return events != 0 && os::is_ready(socket, events, Time{});
  };
  return relay.state() != TlsRelay::State::kOver &&
         (has(relay.outer(), relay.outer_events()) || has(relay.inner(), relay.inner_events()));
}

// All that can happen at one instant.
void work_at(Time now, std::span<TlsRelay> relays) {
  const auto called = [&] { return std::ranges::find_if(relays, is_called); };
  for (auto relay = called(); relay != relays.end(); relay = called()) relay->work(now);
}

TEST_F(TlsRelaysTest, ItIsOverAtOnceWhenBothSidesHaveEnded) {
  constexpr Time kNow{};
  auto wire = pair();
  std::array<TlsRelay, 2> relays{
      TlsRelay(server_.on(std::move(wire[0]), context(TlsSettings::Side::kServer)), kNever),
      TlsRelay(client_.on(std::move(wire[1]), context(TlsSettings::Side::kClient)), kNever)};
  work_at(kNow, relays);
  ASSERT_TRUE(server_.opened && client_.opened);
  client_.opened->socket.reset();
  work_at(kNow, relays);
  EXPECT_EQ(relays[0].state(), TlsRelay::State::kEnding) << "the server may still answer";
  server_.opened->socket.reset();
  work_at(kNow, relays);
  EXPECT_EQ(relays[0].state(), TlsRelay::State::kOver);
  EXPECT_EQ(relays[1].state(), TlsRelay::State::kOver);
}

TEST_F(TlsRelaysTest, APlainConnectionIsHandedOnUntouchedWhereItIsAllowed) {
  auto wire = pair();
  write_all(wire[1].get(), std::string("\0\1", 2));
  relays_->add(server_.on(std::move(wire[0]), context(TlsSettings::Side::kServer), true));
  server_.wait();
  ASSERT_TRUE(server_.opened);
  EXPECT_FALSE(server_.opened->is_tls);
  EXPECT_EQ(read_all(server_.opened->socket.get(), 2), std::string("\0\1", 2));
}

TEST_F(TlsRelaysTest, APlainConnectionIsRefusedElsewhere) {
  auto wire = pair();
  write_all(wire[1].get(), "GET / HTTP/1.1\r\n");
  relays_->add(server_.on(std::move(wire[0]), context(TlsSettings::Side::kServer)));
  server_.wait();
  EXPECT_THAT(server_.refused, HasSubstr("only TLS is allowed"));
  EXPECT_EQ(read_all(wire[1].get(), 1), "") << "closed";
}

TEST_F(TlsRelaysTest, TlsAtAPortWithoutKeysIsNamed) {
  auto wire = pair();
  relays_->add(server_.on(std::move(wire[0]), std::nullopt));
  relays_->add(client_.on(std::move(wire[1]), context(TlsSettings::Side::kClient)));
  server_.wait();
  client_.wait();
  EXPECT_THAT(server_.refused, HasSubstr("no keys"));
  EXPECT_FALSE(client_.opened);
}

TEST_F(TlsRelaysTest, AForeignCertificateIsRefusedWithAReasonOnBothSides) {
  const TestPair foreign = test_member(test_root("other"), {"tims://g/top/0/1"});
  auto wire = pair();
  relays_->add(server_.on(std::move(wire[0]), context(TlsSettings::Side::kServer)));
  TlsSettings s = settings(TlsSettings::Side::kClient, foreign);
  relays_->add(client_.on(std::move(wire[1]), TlsContext::make(s).value()));
  server_.wait();
  EXPECT_THAT(server_.refused, HasSubstr("certificate"));
  EXPECT_FALSE(server_.opened);
  client_.wait();
  // A client of TLS 1.3 has completed its own handshake before it learns of the refusal.
  if (client_.opened) {
    EXPECT_EQ(read_all(client_.opened->socket.get(), 1), "");
  }
}

TEST_F(TlsRelaysTest, GarbageAfterTheFirstByteIsRefused) {
  auto wire = pair();
  write_all(wire[1].get(), "\x16\x03\x01" + std::string(70'000, '\xff'));
  relays_->add(server_.on(std::move(wire[0]), context(TlsSettings::Side::kServer)));
  server_.wait();
  EXPECT_NE(server_.refused, "");
}

TEST_F(TlsRelaysTest, HalfHandshakesEndAndSilentOriginalsAreHandedOn) {
  relays_ = std::move(*TlsRelays::start({.handshake_time = 100ms}));
  auto half = pair();
  auto silent = pair();
  write_all(half[1].get(), "\x16\x03\x01");
  relays_->add(server_.on(std::move(half[0]), context(TlsSettings::Side::kServer)));
  relays_->add(client_.on(std::move(silent[0]), context(TlsSettings::Side::kServer), true));
  server_.wait();
  client_.wait();
  EXPECT_THAT(server_.refused, HasSubstr("in time"));
  ASSERT_TRUE(client_.opened);
  EXPECT_FALSE(client_.opened->is_tls);
}

TEST_F(TlsRelaysTest, OfTooManyHandshakesTheOldestEnds) {
  relays_ = std::move(*TlsRelays::start({.handshakes_max = 2, .first_bytes_max = 1}));
  const TlsContext tls = context(TlsSettings::Side::kServer);
  std::vector<os::File> others;
  for (int i = 0; i < 3; ++i) {
    auto wire = pair();
    write_all(wire[1].get(), "\x16\x03\x01");
    relays_->add(server_.on(std::move(wire[0]), tls));
    others.push_back(std::move(wire[1]));
  }
  EXPECT_EQ(read_all(others[0].get(), 1), "") << "the oldest was closed";
  EXPECT_FALSE(os::is_ready(others[2].get(), POLLIN, os::now()));
  auto first = pair();
  auto second = pair();
  relays_->add(client_.on(std::move(first[0]), tls));
  relays_->add(client_.on(std::move(second[0]), tls));
  EXPECT_EQ(read_all(first[1].get(), 1), "");
}

TEST_F(TlsRelaysTest, ConnectionsOfARevokedCertificateEnd) {
  const auto [server, client] = connected();
  relays_->end_if([&](const TlsRelays::Chain& chain) {
    return !chain.empty() && chain.front() == member_.certificate;
  });
  EXPECT_EQ(read_all(client.get(), 1), "");
  EXPECT_EQ(read_all(server.get(), 1), "");
}

}  // namespace tls_relays_test
}  // namespace tims::security

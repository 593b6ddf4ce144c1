#include "router/link/handshakes.h"

#include <map>

#include <gtest/gtest.h>

namespace tims::link {
namespace handshakes_test {

using namespace std::chrono_literals;

NetAddress address_of(std::uint8_t n) { return NetAddress::v4(10, 0, 0, n, 2010); }

class HandshakesTest : public testing::Test, public Handshaker, public Handshakes::Observer {
 protected:
  // Handshaker
  void begin(std::uint64_t handshake, Side, std::span<const std::byte>) override {
    running[handshake] = 0;
    ++calls;
  }
  void receive(std::uint64_t handshake, std::span<const std::byte> come) override {
    running[handshake] += come.size();
    ++calls;
  }
  void send(std::uint64_t, std::span<const std::byte>) override {}
  void end(std::uint64_t handshake) override {
    running.erase(handshake);
    ++calls;
  }
  // Handshakes::Observer
  void on_message(Time at, Handshakes::One& handshake) override {
    all.answer(at, handshake, bytes);
  }
  void on_failed(Time, const Handshakes::One&, std::string_view why) override { failure = why; }
  void send(const NetAddress&, std::span<const std::byte>) override {}

  Crypto first(std::uint64_t token, std::uint64_t cookie = 5) {
    return {.token = token, .cookie = cookie, .bytes = bytes};
  }

  // The handshaker has done what it was given.
  void work(std::uint64_t handshake) { all.on_progress(now, {.handshake = handshake}); }

  // As many as there is room for, with the tokens from 1 on.
  void fill() {
    for (std::uint64_t n = 1; n <= Handshakes::kAcceptedMax; ++n)
      EXPECT_TRUE(all.accept(now, address_of(1), first(n)));
  }

  Time now{100s};
  const std::array<std::byte, 3> bytes{};
  std::map<std::uint64_t, std::size_t> running;  // bytes received
  std::size_t calls = 0;                         // work for the handshaker
  std::string failure;
  Handshakes all{this, *this};
};

TEST_F(HandshakesTest, AreBoundedAndThoseThatLetUsWaitMakeRoom) {
  fill();
  EXPECT_FALSE(all.accept(now, address_of(1), first(100)));
  EXPECT_EQ(running.size(), Handshakes::kAcceptedMax);
  for (const auto& [number, size] : std::map(running)) all.on_progress(now, {.handshake = number});
  now += Handshakes::kYieldsAfter - 1ns;
  EXPECT_FALSE(all.accept(now, address_of(1), first(100)));
  now += 1ns;
  EXPECT_TRUE(all.accept(now, address_of(1), first(100)));
  EXPECT_EQ(running.size(), Handshakes::kAcceptedMax);
  EXPECT_FALSE(running.contains(1)) << "the oldest";
  const auto counters = all.counters();
  EXPECT_EQ(counters.in_progress, Handshakes::kAcceptedMax);
  EXPECT_EQ(counters.accepted, Handshakes::kAcceptedMax + 1);
  EXPECT_EQ(counters.turned_away, 2U);
  EXPECT_EQ(counters.given_up, 1U);
}

// Its work would have to be done again.
TEST_F(HandshakesTest, OneThatWaitsForThisSideMakesNoRoom) {
  fill();
  now += Handshakes::kTimeMax - 1ns;
  EXPECT_FALSE(all.accept(now, address_of(1), first(100)));
}

// The sum counts: bytes that come one by one gain no time.
TEST_F(HandshakesTest, WhoDripsItsBytesMakesRoomLikeOneThatIsSilent) {
  fill();
  Duration drip = Handshakes::kYieldsAfter / 4;
  Crypto next = first(0);
  for (int n = 1; n <= 4; ++n) {
    for (const auto& [number, size] : std::map(running))
      all.on_progress(now, {.handshake = number});
    now += drip;
    EXPECT_EQ(all.accept(now, address_of(1), first(100)), n == 4) << n;
    next.offset += 3;
    for (std::uint64_t token = 1; token <= Handshakes::kAcceptedMax && n < 4; ++token) {
      next.token = token;
      EXPECT_TRUE(all.on_crypto(now, address_of(1), next));
    }
  }
}

TEST_F(HandshakesTest, KeepTheirCookie) {
  EXPECT_TRUE(all.accept(now, address_of(1), first(1, 5)));
  EXPECT_EQ(all.cookie_of(address_of(1), 1), 5U);
  EXPECT_FALSE(all.cookie_of(address_of(1), 2));
  EXPECT_FALSE(all.cookie_of(address_of(2), 1));
}

// An answer that is not on its way yet is as good as none. One that is may have to be repeated.
TEST_F(HandshakesTest, AnAnswerIsSentAndRepeatedBeforeItsHandshakeMakesRoom) {
  fill();
  const std::vector<std::byte> flight(10);
  for (const auto& [number, size] : std::map(running))
    all.on_progress(now, {.handshake = number, .to_send = flight, .messages = {flight}});
  EXPECT_EQ(all.counters().answered, Handshakes::kAcceptedMax);
  now += Handshakes::kAnsweredYieldsAfter;
  EXPECT_FALSE(all.accept(now, address_of(1), first(100)));
  for (const auto& [number, size] : std::map(running))
    all.on_progress(now, {.handshake = number, .to_send = flight});
  now += Handshakes::kAnsweredYieldsAfter - 1ns;
  EXPECT_FALSE(all.accept(now, address_of(1), first(100)));
  now += 1ns;
  EXPECT_TRUE(all.accept(now, address_of(1), first(100)));
  EXPECT_EQ(all.counters().given_up, 0U);
}

TEST_F(HandshakesTest, EndAfterTheirTime) {
  EXPECT_TRUE(all.accept(now, address_of(1), first(1)));
  EXPECT_LE(all.next_timeout(), now + Handshakes::kTimeMax);
  all.on_timeout(now + Handshakes::kTimeMax - 1ns);
  EXPECT_EQ(all.count(), 1U);
  all.on_timeout(now + Handshakes::kTimeMax);
  EXPECT_EQ(all.count(), 0U);
  EXPECT_TRUE(running.empty());
}

TEST_F(HandshakesTest, BelongToAddressTokenAndCookie) {
  EXPECT_TRUE(all.accept(now, address_of(1), first(1)));
  Crypto next = first(1);
  next.offset = 3;
  EXPECT_FALSE(all.on_crypto(now, address_of(2), next));
  EXPECT_FALSE(all.on_crypto(now, address_of(1), first(1, 6)));
  EXPECT_FALSE(all.on_crypto(now, address_of(1), first(2)));
  EXPECT_TRUE(all.on_crypto(now, address_of(1), next));
  work(running.begin()->first);
  EXPECT_EQ(running.begin()->second, 6U);
}

// However small the pieces are in which the other side sends its bytes.
TEST_F(HandshakesTest, BytesThatComeWhileTheHandshakerWorksAreGivenTogether) {
  EXPECT_TRUE(all.accept(now, address_of(1), first(1)));
  const std::size_t before = calls;
  Crypto next = first(1);
  next.bytes = next.bytes.first(1);
  for (next.offset = 3; next.offset < 1000; ++next.offset)
    EXPECT_TRUE(all.on_crypto(now, address_of(1), next));
  EXPECT_EQ(calls, before);
  work(running.begin()->first);
  EXPECT_EQ(calls, before + 1);
  EXPECT_EQ(running.begin()->second, 1000U);
  work(running.begin()->first);
  EXPECT_TRUE(all.on_crypto(now, address_of(1), next));
  EXPECT_EQ(running.begin()->second, 1001U);
}

// The former one would take the new bytes for its own, and fail.
TEST_F(HandshakesTest, WhoBeginsAgainWithTheSameCookieGetsANewOne) {
  EXPECT_TRUE(all.accept(now, address_of(1), first(1)));
  EXPECT_TRUE(all.on_crypto(now, address_of(1), first(1))) << "repeated";
  work(running.begin()->first);
  const std::array other{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
  const Crypto again{.token = 1, .cookie = 5, .bytes = other};
  EXPECT_FALSE(all.on_crypto(now, address_of(1), again));
  EXPECT_TRUE(running.empty());
  EXPECT_TRUE(all.accept(now, address_of(1), again));
  EXPECT_EQ(running.size(), 1U);
  EXPECT_TRUE(all.on_crypto(now, address_of(1), again));
  EXPECT_EQ(running.begin()->second, 4U);
}

// With one cookie, a stranger could have the handshaker begin again and again.
TEST_F(HandshakesTest, NoneBeginsAgainWhileTheHandshakerWorks) {
  EXPECT_TRUE(all.accept(now, address_of(1), first(1)));
  const std::size_t before = calls;
  std::array<std::byte, 1> other{};
  const Crypto again{.token = 1, .cookie = 5, .bytes = other};
  for (std::size_t n = 1; n <= 1000; ++n) {
    other[0] = static_cast<std::byte>(1 + n % 255);
    EXPECT_TRUE(all.on_crypto(now, address_of(1), again));
  }
  EXPECT_EQ(calls, before);
  work(running.begin()->first);
  EXPECT_FALSE(all.on_crypto(now, address_of(1), again));
  EXPECT_TRUE(all.accept(now, address_of(1), again));
  EXPECT_EQ(running.size(), 1U);
}

TEST_F(HandshakesTest, ACallGoesOnUntilTheOtherSideHasBeenSilentForLong) {
  const auto number = [&] { return running.begin()->first; };
  const auto connect = [&](Duration after, std::uint8_t address, std::uint64_t cookie,
                           bool restarts = false) {
    all.connect(now + after, address_of(address), {1, cookie}, {}, restarts);
    return number();
  };
  const std::uint64_t one = connect(0ms, 1, 5);
  EXPECT_EQ(connect(100ms, 2, 6), one) << "another path has answered, too";
  EXPECT_EQ(connect(500ms, 1, 5), one);
  EXPECT_EQ(connect(599ms, 1, 7), one) << "whoever hears HELLO can forge that";
  EXPECT_EQ(connect(599ms, 2, 7), one);
  const std::uint64_t two = connect(600ms, 1, 7);
  EXPECT_NE(two, one) << "it has restarted";
  EXPECT_EQ(connect(649ms, 1, 8, true), two);
  EXPECT_EQ(connect(650ms, 1, 7, true), two) << "the same cookie";
  EXPECT_EQ(connect(650ms, 2, 8, true), two) << "from elsewhere";
  EXPECT_NE(connect(650ms, 1, 8, true), two) << "it is known to restart";
  EXPECT_EQ(all.count(), 1U);
}

TEST_F(HandshakesTest, AFailureEndsThemAndIsReported) {
  EXPECT_TRUE(all.accept(now, address_of(1), first(1)));
  all.on_progress(now, {.handshake = running.begin()->first, .failure = "revoked"});
  EXPECT_EQ(failure, "revoked");
  EXPECT_EQ(all.count(), 0U);
  all.on_progress(now, {.handshake = 1, .failure = "late"});
  EXPECT_EQ(failure, "revoked");
}

TEST_F(HandshakesTest, TooLongAFlightIsAFailure) {
  EXPECT_TRUE(all.accept(now, address_of(1), first(1)));
  all.on_progress(now, {.handshake = running.begin()->first,
                        .to_send = std::vector<std::byte>(CryptoStream::kBytesMax + 1)});
  EXPECT_EQ(failure, "the handshake is too long");
}

}  // namespace handshakes_test
}  // namespace tims::link

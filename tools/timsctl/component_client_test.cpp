#include "tools/timsctl/component_client.h"

#include <cstring>
#include <deque>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "os/wakeup.h"

namespace timsctl {
namespace component_client_test {

using namespace std::chrono_literals;
using testing::ElementsAre;

constexpr tims::Address kLadar(0x03140000);
constexpr tims::Address kOwn(0x030F0102);

// Remembers what is sent and gives what the test puts in.
class FakeConnection final : public Connection {
 public:
  [[nodiscard]] tims::Address address() const override { return kOwn; }
  [[nodiscard]] tims::AddressWidths widths() const override { return {}; }
  [[nodiscard]] std::string where() const override { return "fake"; }
  [[nodiscard]] std::uint64_t missed() const override { return 0; }
  [[nodiscard]] int descriptor() const override { return event_.get(); }
  tims::Result<void> send(const tims::Envelope& envelope,
                          std::span<const std::byte> body) override {
    sent.push_back(envelope.type);
    bodies.emplace_back(body.begin(), body.end());
    return {};
  }
  tims::Result<void> send_to_router(tims::Envelope, std::span<const std::byte>) override {
    return tims::Errc::kRefused;
  }
  tims::Result<Message> take() override {
    if (waiting.empty()) return tims::Errc::kEmpty;
    Message message = std::move(waiting.front());
    waiting.pop_front();
    return message;
  }

  std::vector<int> sent;
  std::vector<std::vector<std::byte>> bodies;
  std::deque<Message> waiting;

 private:
  tims::os::File event_ = std::move(*tims::os::make_event_fd());
};

Message from_ladar(std::int8_t type, std::vector<std::uint32_t> numbers = {}) {
  Message m{.header = {.type = type, .dest = kOwn, .src = kLadar}, .body = {}};
  m.body.resize(numbers.size() * 4);
  if (!numbers.empty()) std::memcpy(m.body.data(), numbers.data(), m.body.size());
  return m;
}
tims::Time at(tims::Duration since) { return tims::Time(since); }

TEST(Subscription, AsksWithPeriodAndMailbox) {
  FakeConnection connection;
  Subscription ladar(kLadar, 200);
  ASSERT_TRUE(ladar.on_time(connection, at(10s)));
  EXPECT_THAT(connection.sent, ElementsAre(tims::type::kGetContData));
  std::array<std::uint32_t, 2> numbers{};
  ASSERT_EQ(connection.bodies[0].size(), sizeof numbers);
  std::memcpy(numbers.data(), connection.bodies[0].data(), sizeof numbers);
  EXPECT_THAT(numbers, ElementsAre(200U, kOwn.raw()));
  ASSERT_TRUE(ladar.on_time(connection, at(10s + 500ms)));
  EXPECT_EQ(connection.sent.size(), 1U) << "the answer may take its time";
}

TEST(Subscription, OnlyDataIsData) {
  Subscription ladar(kLadar, 0);
  EXPECT_FALSE(ladar.on_message(from_ladar(tims::type::kContData, {40}), at(1s)));
  EXPECT_EQ(ladar.state(), Subscription::State::kRunning);
  EXPECT_EQ(ladar.granted_ms(), 40U);
  EXPECT_TRUE(ladar.on_message(from_ladar(tims::type::kData, {1, 2}), at(1s)));
  EXPECT_FALSE(ladar.on_message(from_ladar(tims::type::kOk), at(1s)));
}

TEST(Subscription, ASwappedAnswerIsUnderstood) {
  Subscription ladar(kLadar, 0);
  Message answer = from_ladar(tims::type::kContData, {__builtin_bswap32(40)});
  answer.header.flags ^= tims::flag::kBodyLittleEndian;
  (void)ladar.on_message(answer, at(1s));
  EXPECT_EQ(ladar.granted_ms(), 40U);
}

TEST(Subscription, AsksAgainWhenOffGoneOrSilent) {
  FakeConnection connection;
  Subscription ladar(kLadar, 0);
  (void)ladar.on_message(from_ladar(tims::type::kError), at(10s));
  EXPECT_EQ(ladar.state_name(), "off");
  EXPECT_EQ(ladar.next_time(), at(11s));
  (void)ladar.on_message(from_ladar(tims::type::kNotAvailable), at(20s));
  EXPECT_EQ(ladar.state_name(), "no_mailbox");
  EXPECT_EQ(ladar.next_time(), at(21s));
  (void)ladar.on_message(from_ladar(tims::type::kContData, {60'000}), at(29s));
  (void)ladar.on_message(from_ladar(tims::type::kData), at(30s));
  EXPECT_EQ(ladar.next_time(), at(30s + 180s)) << "three periods, or it would ask in between";
}

TEST(Subscriptions, EndingStopsTheComponentsThatKnowUs) {
  FakeConnection connection;
  const Signals signals;
  {
    Subscriptions both(connection, {kLadar, tims::Address(0x03150000)}, 0);
    connection.waiting.push_back(from_ladar(tims::type::kContData, {40}));
    Message gone = from_ladar(tims::type::kNotAvailable);
    gone.header.src = tims::Address(0x03150000);
    connection.waiting.push_back(gone);
    connection.waiting.push_back(from_ladar(tims::type::kData, {7}));
    const auto data = both.next(signals, tims::kNever);
    ASSERT_TRUE(data);
    EXPECT_EQ(data->index, 0U);
    connection.sent.clear();
    connection.waiting.push_back(from_ladar(tims::type::kOk));
  }
  EXPECT_THAT(connection.sent, ElementsAre(tims::type::kStopContData));
  EXPECT_TRUE(connection.waiting.empty()) << "the answer was taken before the mailbox goes";
}

}  // namespace component_client_test
}  // namespace timsctl

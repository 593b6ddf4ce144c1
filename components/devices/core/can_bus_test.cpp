#include "components/devices/core/can_bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::device {
namespace can_bus_test {

using namespace std::chrono_literals;

constexpr std::uint32_t kBusOff = 0x20000040;
constexpr std::uint32_t kRestarted = 0x20000100;
constexpr std::uint32_t kNoAcknowledge = 0x20000020;
constexpr std::uint32_t kController = 0x20000004;
constexpr std::uint32_t kBusError = 0x20000088;

class CanBusTest : public testing::Test {
 protected:
  std::optional<std::string> error(std::uint32_t id, int controller = 0) {
    const std::array<std::byte, 8> bytes{std::byte{0}, static_cast<std::byte>(controller)};
    return bus_.on_error_frame(id, bytes, now_);
  }
  CanBus bus_{"can0"};
  Time now_{1000s};
};

TEST_F(CanBusTest, ErrorsAreReportedOnceASecond) {
  EXPECT_THAT(error(kNoAcknowledge).value_or(""), testing::HasSubstr("receives no acknowledge"));
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(error(kNoAcknowledge));
  now_ += 1s;
  EXPECT_THAT(error(kController, 0x20).value_or(""), testing::HasSubstr("error passive"));
  EXPECT_FALSE(error(kBusError));
  EXPECT_FALSE(error(kController, 0x01));
  EXPECT_EQ(bus_.summary(), "1001 without acknowledge, 1 lost, 1 error passive, 1 errors");
  EXPECT_FALSE(bus_.is_off());
}

TEST_F(CanBusTest, ComesBackLaterEachTimeAndNotForEver) {
  Duration pause = 100ms;
  const Time first = now_ + pause;
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(error(kBusOff)) << i;
    EXPECT_TRUE(bus_.is_off());
    EXPECT_EQ(bus_.next_restart(), now_ + pause) << i;
    now_ = bus_.next_restart();
    bus_.on_restart(now_);
    EXPECT_EQ(bus_.next_restart(), tims::kNever);
    error(kRestarted);
    EXPECT_FALSE(bus_.is_off());
    EXPECT_FALSE(bus_.failure(now_));
    pause = std::min<Duration>(2 * pause, 2s);
    now_ += 1s;
  }
  error(kBusOff);
  EXPECT_EQ(bus_.next_restart(), first + 1min);
  EXPECT_THAT(bus_.failure(now_).value_or(""), testing::HasSubstr("more than 5 times a minute"));
  bus_.on_restart(first + 1min);
  EXPECT_FALSE(bus_.failure(now_));
}

TEST_F(CanBusTest, ReopeningKeepsTheState) {
  bus_.on_open(now_);
  EXPECT_EQ(bus_.next_restart(), tims::kNever);
  error(kBusOff);
  const Time planned = bus_.next_restart();
  now_ += 50ms;
  bus_.on_open(now_);
  EXPECT_EQ(bus_.next_restart(), planned);
  bus_.on_restart(planned);
  now_ += 10s;
  EXPECT_TRUE(bus_.failure(now_));
  bus_.on_open(now_);  // the controller may have restarted while the interface was closed
  EXPECT_FALSE(bus_.failure(now_));
  EXPECT_EQ(bus_.next_restart(), now_ + 200ms);
}

TEST_F(CanBusTest, AfterAQuietMinuteItStartsAgain) {
  for (int i = 0; i < 20; ++i) {
    error(kBusOff);
    EXPECT_EQ(bus_.next_restart(), now_ + 100ms) << i;
    bus_.on_restart(now_ + 100ms);
    error(kRestarted);
    now_ += 2min;
  }
  EXPECT_EQ(bus_.counters().restarts, 20U);
}

TEST_F(CanBusTest, AControllerThatDoesNotRecoverIsGivenUp) {
  error(kBusOff);
  bus_.on_restart(now_ + 100ms);
  EXPECT_FALSE(bus_.failure(now_ + 5s));
  EXPECT_THAT(bus_.failure(now_ + 6s).value_or(""), testing::HasSubstr("restart-ms 100"));
  bus_.on_frame();  // the kernel has restarted the controller
  EXPECT_FALSE(bus_.failure(now_ + 6s));
}

TEST_F(CanBusTest, AStormOfBusOffIsOne) {
  for (int i = 0; i < 1000; ++i) error(kBusOff);
  EXPECT_EQ(bus_.next_restart(), now_ + 100ms);
  EXPECT_EQ(bus_.counters().bus_off, 1000U);
}

TEST_F(CanBusTest, AStormOfBusOffIsOneSentenceASecond) {
  CanBus bus("can0");
  int reports = 0;
  for (Time now{10s}; now < Time{20s}; now += 1ms) {
    reports += bus.on_error_frame(0x40, std::array<std::byte, 8>{}, now) ? 1 : 0;
    bus.on_frame();  // the bus works between two bus-off events
  }
  EXPECT_EQ(reports, 10);
  EXPECT_EQ(bus.counters().bus_off, 10'000U);
}

TEST(CanQueueTest, TheLowestIdentifierGoesFirstAndEqualOnesInTheirOrder) {
  CanQueue queue;
  const std::array bytes = {std::byte{1}, std::byte{2}};
  constexpr std::uint32_t kExtended = 0x80000000;
  EXPECT_TRUE(queue.add(kExtended | 0x201U << 18, {}, tims::kNever));
  EXPECT_TRUE(queue.add(kExtended | 1, {}, tims::kNever));
  EXPECT_TRUE(queue.add(0x201, std::span(bytes).first(1), tims::kNever));
  EXPECT_TRUE(queue.add(0x080, {}, tims::kNever));
  EXPECT_TRUE(queue.add(0x201, bytes, tims::kNever));
  std::vector<std::pair<std::uint32_t, int>> order;
  for (; !queue.empty(); queue.pop()) order.emplace_back(queue.front().id, queue.front().size);
  EXPECT_THAT(order, testing::ElementsAre(std::pair(kExtended | 1, 0), std::pair(0x080, 0),
                                          std::pair(0x201, 1), std::pair(0x201, 2),
                                          std::pair(kExtended | 0x201U << 18, 0)));
}

TEST(CanQueueTest, ItIsBoundedAndWhatIsLateGoes) {
  CanQueue queue;
  std::size_t taken = 0;
  while (taken < 1000 && queue.add(0x100, {}, Time{1s} + taken * 1ms)) ++taken;
  EXPECT_EQ(taken, 64U);
  EXPECT_EQ(queue.drop_late(Time{1s}), 0U);
  EXPECT_EQ(queue.drop_late(Time{1s + 10ms}), 10U);
  EXPECT_TRUE(queue.add(0x100, {}, tims::kNever));
  EXPECT_EQ(queue.drop_late(Time{100s}), 54U);
  EXPECT_EQ(queue.front().deadline, tims::kNever);
  EXPECT_FALSE(queue.add(0x100, std::array<std::byte, 9>{}, tims::kNever));
}

}  // namespace can_bus_test
}  // namespace rack::device

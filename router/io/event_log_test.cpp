#include "router/io/event_log.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tims::io {
namespace {

using namespace std::chrono_literals;
using core::EventKind;
using testing::HasSubstr;

struct LimitedLogTest : testing::Test {
  void happens(EventKind kind, std::string_view router = "base") {
    const core::Peer peer{.id = core::ClientId(1),
                          .port = core::PortKind::kLink,
                          .name = core::Text<31>(router),
                          .endpoint = std::string_view("10.0.0.1:2010")};
    log.on_event(now,
                 {.at = now, .kind = kind, .reason = core::CloseReason::kSilent, .client = peer});
  }
  void flap(int times) {
    for (int i = 0; i < times; ++i) {
      happens(EventKind::kLinkDown);
      happens(EventKind::kLinkUp);
    }
  }
  void pass(Duration time) {
    now += time;
    while (log.next_timeout() <= now) log.on_timeout(now);
  }

  std::vector<std::string> lines;
  Time now{1h};
  LimitedLog log{[this](config::LogLevel, std::string_view text) { lines.emplace_back(text); }};
};

TEST_F(LimitedLogTest, SingleChangesAreWrittenAtOnce) {
  flap(1);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_THAT(lines[0], HasSubstr("base (10.0.0.1:2010) is down"));
  EXPECT_THAT(lines[1], HasSubstr("is up"));
  pass(10min);
  EXPECT_EQ(lines.size(), 2U);
  EXPECT_EQ(log.next_timeout(), kNever);
}

TEST_F(LimitedLogTest, AFlappingLinkIsOneLineAMinute) {
  flap(3);
  EXPECT_EQ(lines.size(), 6U);
  flap(20);
  happens(EventKind::kLinkDown);
  EXPECT_EQ(lines.size(), 6U);
  pass(1min);
  ASSERT_EQ(lines.size(), 7U);
  EXPECT_THAT(lines[6], HasSubstr("is down"));
  EXPECT_THAT(lines[6], HasSubstr("(41 lines like this were held back)"));
  for (int minute = 0; minute < 10; ++minute) {
    flap(5);
    pass(1min);
  }
  EXPECT_EQ(lines.size(), 17U);
  EXPECT_THAT(lines.back(), HasSubstr("is up"));
}

TEST_F(LimitedLogTest, AfterAQuietMinuteItIsTrustedAgain) {
  flap(10);
  pass(1min);
  pass(1min);
  lines.clear();
  flap(1);
  EXPECT_EQ(lines.size(), 2U);
}

TEST_F(LimitedLogTest, OtherLinksAreNotHeldBackWithIt) {
  flap(10);
  lines.clear();
  happens(EventKind::kLinkDown, "robot1");
  happens(EventKind::kUplinkChanged);
  EXPECT_EQ(lines.size(), 2U);
}

TEST_F(LimitedLogTest, RefusalsOfOneKindAreHeldBackWhoeverCausesThem) {
  for (int i = 0; i < 1000; ++i)
    log.on_event(now, {.at = now,
                       .kind = EventKind::kAddressRefused,
                       .address = Address(static_cast<std::uint32_t>(i)),
                       .client = {.name = std::string_view("guest")}});
  happens(EventKind::kLinkDown);
  ASSERT_EQ(lines.size(), 7U);
  EXPECT_THAT(lines[0], HasSubstr("refused to guest"));
  EXPECT_THAT(lines[6], HasSubstr("is down"));
  pass(1min);
  ASSERT_EQ(lines.size(), 8U);
  EXPECT_THAT(lines[7], HasSubstr("(994 lines like this were held back)"));
}

TEST_F(LimitedLogTest, NamesOfLinksAreNotKeptWithoutEnd) {
  for (int i = 0; i < 1000; ++i) happens(EventKind::kLinkUp, "robot" + std::to_string(i));
  EXPECT_EQ(lines.size(), 256U + 6U);
  pass(1min);
  EXPECT_THAT(lines.back(), HasSubstr("held back"));
}

TEST(LimitedLog, TellsAtTheEndWhatItHolds) {
  std::vector<std::string> lines;
  {
    LimitedLog log([&](config::LogLevel, std::string_view text) { lines.emplace_back(text); });
    for (int i = 0; i < 7; ++i) log.on_event(Time(1h), {.kind = EventKind::kLinkUp});
    EXPECT_EQ(lines.size(), 6U);
  }
  EXPECT_EQ(lines.size(), 7U);
}

}  // namespace

}  // namespace tims::io

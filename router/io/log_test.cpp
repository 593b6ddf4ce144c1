#include "router/io/log.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "os/file.h"

namespace tims::io {
namespace log_test {

using testing::EndsWith;
using testing::HasSubstr;
using namespace std::chrono_literals;
using core::EventKind;

TEST(Printable, TextsStayAsTheyAre) {
  EXPECT_EQ(printable("Ladar(3/0) registered by laser (pid 811)"),
            "Ladar(3/0) registered by laser (pid 811)");
  EXPECT_EQ(printable("Gr\u00fc\u00dfe \u2013 \u20ac \U0001F916"),
            "Gr\u00fc\u00dfe \u2013 \u20ac \U0001F916");
  EXPECT_EQ(printable(""), "");
}

TEST(Printable, WhatEndsALineOrMovesATerminalIsEscaped) {
  EXPECT_EQ(printable("a\nb"), "a\\nb");
  EXPECT_EQ(printable("\x1b[2J\r\t\x7f"), "\\x1b[2J\\x0d\\x09\\x7f");
  EXPECT_EQ(printable(std::string_view("\0x", 2)), "\\x00x");
  EXPECT_EQ(printable("\xC2\x9B"), "\\xc2\\x9b") << "control sequence introducer";
  EXPECT_EQ(printable("\u2028"), "\\xe2\\x80\\xa8");
  EXPECT_EQ(printable("\u202e"), "\\xe2\\x80\\xae") << "from right to left";
  EXPECT_EQ(printable("\u2066"), "\\xe2\\x81\\xa6");
}

TEST(Printable, BytesThatAreNoTextAreEscaped) {
  EXPECT_EQ(printable("\xFF\xC3"), "\\xff\\xc3");
  EXPECT_EQ(printable("\xE2\x82"), "\\xe2\\x82");
  EXPECT_EQ(printable("\xC3(x"), "\\xc3(x");
}

TEST(Printable, IsBounded) {
  EXPECT_EQ(printable(std::string(kLogTextMax - 7, 'x')), std::string(kLogTextMax - 7, 'x'));
  EXPECT_LE(printable(std::string(10'000, '\n')).size(), kLogTextMax);
  EXPECT_THAT(printable(std::string(10'000, 'x')), EndsWith("x..."));
}

struct LogTest : testing::Test {
  LogTest() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
    reader = os::File(ends[0]);
    writer = os::File(ends[1]);
    ::fcntl(reader.get(), F_SETFL, O_NONBLOCK);
  }
  std::string read_all() {
    std::string text;
    std::array<char, 4096> some{};
    for (ssize_t n = 0; (n = ::read(reader.get(), some.data(), some.size())) > 0;)
      text.append(some.data(), static_cast<std::size_t>(n));
    return text;
  }
  os::File reader;
  os::File writer;
};

TEST_F(LogTest, ALineIsOneLine) {
  Log log(config::LogLevel::kInfo, writer.get());
  log.info("evil\nerror: all is lost");
  EXPECT_THAT(read_all(), EndsWith(" evil\\nerror: all is lost\n"));
}

// A pipe whose reader stopped: 64 KiB, and the next line would wait for ever.
TEST_F(LogTest, AReaderThatDoesNotReadStopsNobody) {
  const Log log(config::LogLevel::kInfo, writer.get());
  for (int i = 0; i < 1000; ++i) log.always(config::LogLevel::kInfo, std::string(1000, 'x'));
  const std::string taken = read_all();
  const auto lines = std::count(taken.begin(), taken.end(), '\n');
  EXPECT_GT(lines, 10);
  EXPECT_LT(lines, 100);
  EXPECT_EQ(taken.back(), '\n');
  log.always(config::LogLevel::kInfo, "back again");
  EXPECT_THAT(read_all(), HasSubstr("back again (" + std::to_string(1000 - lines) +
                                    " lines before this one were dropped)\n"));
  log.always(config::LogLevel::kInfo, "as before");
  EXPECT_THAT(read_all(), EndsWith("as before\n"));
}

struct LimitedLogTest : testing::Test {
  void happens(EventKind kind, std::string_view router = "base") {
    const core::Peer peer{.id = core::ClientId(1),
                          .port = core::PortKind::kLink,
                          .name = router,
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
  EXPECT_THAT(lines[6], HasSubstr("(41 similar lines were suppressed)"));
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
  EXPECT_THAT(lines[7], HasSubstr("(994 similar lines were suppressed)"));
}

TEST_F(LimitedLogTest, NamesOfLinksAreNotKeptWithoutEnd) {
  for (int i = 0; i < 1000; ++i) happens(EventKind::kLinkUp, "robot" + std::to_string(i));
  EXPECT_EQ(lines.size(), 256U + 6U);
  pass(1min);
  EXPECT_THAT(lines.back(), HasSubstr("suppressed"));
}

TEST(LimitedLog, WritesHeldLinesAtTheEnd) {
  std::vector<std::string> lines;
  {
    LimitedLog log([&](config::LogLevel, std::string_view text) { lines.emplace_back(text); });
    for (int i = 0; i < 7; ++i) log.on_event(Time(1h), {.kind = EventKind::kLinkUp});
    EXPECT_EQ(lines.size(), 6U);
  }
  EXPECT_EQ(lines.size(), 7U);
}

}  // namespace log_test

}  // namespace tims::io

#include "tests/support/inbox.h"

#include <list>

#include <gtest/gtest.h>

#include "base/text.h"
#include "tests/support/origins.h"
#include "wire/header.h"

namespace tims::test {
namespace inbox_test {

constexpr int kAnne = 1;
constexpr int kBob = 2;

class InboxTest : public testing::Test {
 protected:
  static OwnedMessage message(std::uint8_t seq_nr, std::string_view body = "00") {
    const std::vector<std::byte> bytes = *base::parse_hex(body);
    return {{.type = -6,
             .seq_nr = seq_nr,
             .dest = Address(10),
             .src = Address(20),
             .length = static_cast<std::uint32_t>(kHeaderSize + bytes.size())},
            bytes};
  }

  void expect(int origin, const OwnedMessage& m) {
    recorded::Message recorded{false, std::vector<std::byte>(kHeaderSize)};
    wire::encode_header(m.header, wire::HeaderBytes(recorded.bytes.data(), kHeaderSize));
    recorded.bytes.insert(recorded.bytes.end(), m.body.begin(), m.body.end());
    lines_.push_back({.number = 1, .event = std::move(recorded)});
    inbox_.expect({&lines_.back(), origin});
  }
  void arrive(OwnedMessage m) { inbox_.arrive(std::move(m), 1); }

  // The differences, one letter each: Missing, Surplus, Order, Changed.
  std::string findings() {
    inbox_.finish();
    std::string text;
    for (const Inbox::Finding& f : inbox_.take_findings()) {
      text += f.out_of_order ? 'O' : !f.got ? 'M' : !f.expected ? 'S' : 'C';
    }
    return text;
  }

  Inbox inbox_;
  std::list<recorded::Line> lines_;  // stay where they are
};

TEST_F(InboxTest, AsRecorded) {
  expect(kAnne, message(1));
  EXPECT_TRUE(inbox_.is_waiting());
  arrive(message(1));
  EXPECT_FALSE(inbox_.is_waiting());
  EXPECT_EQ(findings(), "");
  EXPECT_EQ(inbox_.matched(), 1U);
}

TEST_F(InboxTest, MayArriveBeforeItsLineInTheRecording) {
  arrive(message(1));
  arrive(message(2));
  expect(kAnne, message(1));
  expect(kAnne, message(2));
  EXPECT_EQ(findings(), "");
}

TEST_F(InboxTest, Missing) {
  expect(kAnne, message(1));
  expect(kAnne, message(2));
  arrive(message(2));
  EXPECT_EQ(findings(), "M") << "only the first is missing";
}

TEST_F(InboxTest, Surplus) {
  expect(kAnne, message(1));
  arrive(message(1));
  arrive(message(1));
  EXPECT_EQ(findings(), "S");
}

TEST_F(InboxTest, ChangedIsReportedWithTheExpectedOne) {
  expect(kAnne, message(1, "aa"));
  arrive(message(1, "ab"));
  EXPECT_EQ(findings(), "C");
}

TEST_F(InboxTest, OrderOfOneOrigin) {
  expect(kAnne, message(1));
  expect(kAnne, message(2));
  arrive(message(2));
  arrive(message(1));
  EXPECT_EQ(findings(), "O");
}

TEST_F(InboxTest, OrderOfOneOriginWhenBothArrivedEarly) {
  arrive(message(2));
  arrive(message(1));
  expect(kAnne, message(1));
  expect(kAnne, message(2));
  EXPECT_EQ(findings(), "O");
}

TEST_F(InboxTest, OrderOfOneOriginWhenOneArrivedEarly) {
  arrive(message(2));
  expect(kAnne, message(1));
  expect(kAnne, message(2));
  arrive(message(1));
  EXPECT_EQ(findings(), "O");
}

TEST_F(InboxTest, AnyOrderOfTwoOrigins) {
  expect(kAnne, message(1));
  expect(kBob, message(2));
  arrive(message(2));
  arrive(message(1));
  EXPECT_EQ(findings(), "");
}

TEST(IsEquivalent, ByteOrderOfTheHeaderIsFree) {
  const Header a{.flags = 3, .type = -6, .dest = Address(1), .src = Address(2)};
  Header b = a;
  b.flags = 2;
  EXPECT_TRUE(is_equivalent({a, {}}, {b, {}}, false));
  b.flags = 1;  // another byte order of the body
  EXPECT_FALSE(is_equivalent({a, {}}, {b, {}}, false));
  EXPECT_TRUE(is_equivalent({a, {}}, {b, {}}, true)) << "the router's own messages have no body";
  b.flags = 3;
  b.priority = 1;
  EXPECT_FALSE(is_equivalent({a, {}}, {b, {}}, true));
}

TEST(Origins, FirstSenderOfTheSame) {
  const Header header{.flags = 0, .type = 5, .dest = Address(1), .src = Address(2)};
  Header delivered = header;
  delivered.flags = flag::kHeaderLittleEndian;
  Origins origins;
  origins.sent(kAnne, {header, {}});
  origins.sent(kBob, {header, {}});
  EXPECT_EQ(origins.of_delivered({delivered, {}}), kAnne);
  EXPECT_EQ(origins.of_delivered({delivered, {}}), kBob);
  EXPECT_EQ(origins.of_delivered({delivered, {}}), kFromRouter);
}

}  // namespace inbox_test
}  // namespace tims::test

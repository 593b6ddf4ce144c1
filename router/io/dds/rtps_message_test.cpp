#include "router/io/dds/rtps_message.h"

#include <gtest/gtest.h>

namespace tims::io {
namespace {

std::vector<std::byte> bytes(std::initializer_list<int> octets) {
  std::vector<std::byte> made;
  for (const int octet : octets) made.push_back(static_cast<std::byte>(octet));
  return made;
}

TEST(RtpsMessage, OfTheOtherByteOrderIsRead) {
  const auto message = bytes({'R',  'T',  'P', 'S',  2, 3, 1, 15,    // header
                              1,    2,    3,   4,    5, 6, 7, 8,     // from
                              9,    10,   11,  12,                   //
                              0x15, 4,    0,   0,    0, 0, 0, 16,    // DATA
                              0,    1,    0,   0xC7, 0, 1, 0, 0xC2,  // of SPDP
                              0,    0,    0,   0,    0, 0, 0, 1,     //
                              0,    2,    0,   0,                    // PL_CDR_BE
                              0,    2,    0,   8,    0, 0, 0, 7,     // lease
                              0,    0,    0,   0,                    //
                              0,    0x2C, 0,   8,    0, 0, 0, 3,     // user data
                              'a',  'b',  'c', 0,    0, 1, 0, 0});
  const auto read = parse_rtps(message);
  ASSERT_TRUE(read && read->announced);
  EXPECT_EQ(read->from, (link::DdsParticipant{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
  EXPECT_EQ(read->announced->lease, std::chrono::seconds(7));
  EXPECT_EQ(read->announced->user_data.size(), 3);
  EXPECT_FALSE(read->to || read->ends);
}

TEST(RtpsMessage, TheSenderStandsInTheHeader) {
  const auto message =
      bytes({'R', 'T', 'P', 'S', 2, 3, 1, 15, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  EXPECT_EQ(rtps_sender(message), (link::DdsParticipant{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
  EXPECT_FALSE(rtps_sender(std::span(message).first(19)));
  EXPECT_FALSE(rtps_sender(std::vector<std::byte>(20)));
}

TEST(RtpsMessage, AHeartbeatTellsWhatThereIs) {
  const auto message = encode(RtpsHeartbeat{.from = {1},
                                            .writer = {0, 0, 2, 3},
                                            .to = {7},
                                            .first = 5,
                                            .last = (1ULL << 32) + 6,
                                            .count = 0x10001});
  const auto read = parse_rtps(message);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->from, link::DdsParticipant{1});
  EXPECT_EQ(read->to, link::DdsParticipant{7});
  const auto expected = bytes({7, 1, 28, 0, 0, 0, 0, 0, 0, 0, 2, 3, 0, 0, 0, 0,  //
                               5, 0, 0,  0, 1, 0, 0, 0, 6, 0, 0, 0, 1, 0, 1, 0});
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), message.end() - 32));
}

}  // namespace
}  // namespace tims::io

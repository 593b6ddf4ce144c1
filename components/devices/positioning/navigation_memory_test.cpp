// The dialogues of receivers, gyros, compasses and clocks allocate no memory during operation.
#include <gtest/gtest.h>

#include "components/devices/core/test_bytes.h"
#include "components/devices/positioning/cmps03.h"
#include "components/devices/positioning/dcf77.h"
#include "components/devices/positioning/nmea_receiver.h"
#include "components/devices/positioning/ublox.h"
#include "components/devices/positioning/xsens.h"
#include "rack/devices/pieces.h"
#include "tests/support/counted_new.h"

namespace rack::device {
namespace navigation_memory_test {

class SilentOutput : public Output {
 public:
  void send(std::span<const std::byte>, std::uint32_t) override {}
};

// Passes the bytes to a dialogue and returns the number of data sets.
template <class Data, class Dialog>
std::size_t allocations_of(Dialog& dialogue, std::span<const std::byte> bytes, int& found) {
  SilentOutput out;
  Time now{std::chrono::seconds(1000)};
  dialogue.start(now, out);
  Data data;
  Time recorded;
  const std::size_t before = tims::test::allocations();
  in_pieces({.bytes = bytes, .first = now, .last = now}, 16, [&](const Arrival& piece) {
    dialogue.on_arrival(piece, out);
    if (dialogue.take(data, recorded)) ++found;
  });
  return tims::test::allocations() - before;
}

TEST(NavigationMemoryTest, NoneIsAskedForWhileOn) {
  int found = 0;
  NmeaReceiver receiver({.only_listen = true});
  const auto sentences = bytes_of_file("nmea/unicore-um621.log");
  EXPECT_EQ(allocations_of<GpsData>(receiver, sentences, found), 0U);
  EXPECT_EQ(std::exchange(found, 0), 20);

  Ublox ublox({.only_listen = true});
  const auto frames = bytes_of_file("ubx/pygpsdata-MIXED.log");
  EXPECT_EQ(allocations_of<GpsData>(ublox, frames, found), 0U);
  EXPECT_GE(std::exchange(found, 0), 39);

  Xsens gyro({.only_listen = true});
  std::vector<std::byte> messages;
  const std::vector<std::byte> sample(50, std::byte{0x3F});
  for (int i = 0; i < 100; ++i) append_xsens(messages, xsens::kData, sample);
  EXPECT_EQ(allocations_of<GyroData>(gyro, messages, found), 0U);
  EXPECT_EQ(std::exchange(found, 0), 100);

  Cmps03 compass({});
  const auto lines = bytes_of_text("$0900\n$1800\nnoise\n$2700\n");
  EXPECT_EQ(allocations_of<CompassData>(compass, lines, found), 0U);
  EXPECT_GT(std::exchange(found, 0), 0);

  Dcf77 clock(Dcf77Kind::kMeinberg);
  const auto telegrams = bytes_of_text(
      "\x02"
      "D:23.11.26;T:1;U:12.34.56;    \x03");
  EXPECT_EQ(allocations_of<ClockData>(clock, telegrams, found), 0U);
  EXPECT_EQ(found, 1);
}

}  // namespace navigation_memory_test
}  // namespace rack::device

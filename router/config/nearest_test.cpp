#include "router/config/nearest.h"

#include <array>

#include <gtest/gtest.h>

namespace tims::config {
namespace {

TEST(Nearest, CountsEdits) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("listen", "listen"), 0U);
  EXPECT_EQ(edit_distance("listn", "listen"), 1U);
  EXPECT_EQ(edit_distance("listeen", "listen"), 1U);
  EXPECT_EQ(edit_distance("liszen", "listen"), 1U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("abc", ""), 3U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(Nearest, ASwapOfNeighboursIsOneEdit) {
  EXPECT_EQ(edit_distance("litsen", "listen"), 1U);
  EXPECT_EQ(edit_distance("tpc", "tcp"), 1U);
}

TEST(Nearest, GivesTheBestOfWhatIsNear) {
  constexpr std::array<std::string_view, 4> kKnown{"tcp.listen", "http.listen", "tcp.queue", "log"};
  EXPECT_EQ(nearest("tcp.lisen", kKnown), "tcp.listen");
  EXPECT_EQ(nearest("htp.listen", kKnown), "http.listen");
  EXPECT_EQ(nearest("tcp.qeue", kKnown), "tcp.queue");
  EXPECT_EQ(nearest("lgo", kKnown), "log");
}

TEST(Nearest, GivesNothingWhenNothingIsNear) {
  constexpr std::array<std::string_view, 2> kKnown{"tcp.listen", "log"};
  EXPECT_EQ(nearest("flux.capacitor", kKnown), std::nullopt);
  EXPECT_EQ(nearest("x", kKnown), std::nullopt);
  EXPECT_EQ(nearest("", kKnown), std::nullopt);
  EXPECT_EQ(nearest("tcp.listen", {}), std::nullopt);
}

}  // namespace
}  // namespace tims::config

#include "tools/sim/quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace timsctl::sim {
namespace quality_test {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Arguments = std::vector<std::string>;

LineState after(const LineState& now, const Arguments& arguments, const LineState& own = {}) {
  const auto state = changed(now, own, arguments, built_in_profiles());
  EXPECT_TRUE(state) << state.error().detail();
  return state ? *state : LineState{};
}
std::string refusal(const Arguments& arguments) {
  const auto state = changed({}, {}, arguments, built_in_profiles());
  return state ? "accepted" : state.error().detail();
}

TEST(Quality, KeysAreAddedToWhatIsThere) {
  const LineState first = after({}, {"loss=10%"});
  const LineState second = after(first, {"delay=20ms", "rate=50Mbit"});
  EXPECT_DOUBLE_EQ(second.up.loss, 0.1);
  EXPECT_EQ(second.down.delay, 20ms);
  EXPECT_EQ(second.up.rate_bits, 50'000'000U);
  EXPECT_EQ(to_string(second), "loss 10% delay 20ms rate 50Mbit");
}

TEST(Quality, AProfileTakesThePlaceOfAll) {
  const LineState state = after(after({}, {"duplicate=5%"}), {"lte"});
  EXPECT_EQ(state.up, built_in_profiles().at("lte"));
}

TEST(Quality, HealGoesBackToTheLinesOwn) {
  const LineState own = after({}, {"wifi"});
  const LineState bad = after(own, {"cut", "loss=50%"}, own);
  EXPECT_EQ(to_string(bad), "cut");
  EXPECT_EQ(after(bad, {"heal"}, own), own);
  EXPECT_EQ(after(bad, {"off"}, own), own);
}

TEST(Quality, OneDirectionAlone) {
  const LineState state = after({}, {"blackout", "direction=up"});
  EXPECT_TRUE(state.up.blackout);
  EXPECT_FALSE(state.down.blackout);
  EXPECT_EQ(to_string(state), "up: blackout, down: perfect");
  const LineState healed = after(state, {"direction=up", "heal"});
  EXPECT_EQ(healed, LineState());
}

TEST(Quality, RatesInBitsOrBytes) {
  EXPECT_EQ(after({}, {"rate=6MB"}).up.rate_bits, 48'000'000U);
  EXPECT_EQ(after({}, {"rate=1.5Mbit"}).up.rate_bits, 1'500'000U);
  EXPECT_EQ(after({}, {"rate=0"}).up.rate_bits, 0U);
  EXPECT_EQ(rate_text(250'000), "250kbit");
}

TEST(Quality, RefusesWhatMakesNoSense) {
  EXPECT_THAT(refusal({"los=1%"}), HasSubstr("did you mean loss?"));
  EXPECT_THAT(refusal({"wify"}), HasSubstr("did you mean wifi?"));
  EXPECT_THAT(refusal({"nonsense"}), HasSubstr("known: cut, heal, off, blackout, cable"));
  EXPECT_THAT(refusal({"loss=x"}), HasSubstr("loss requires a share such as \"1%\", not \"x\""));
  EXPECT_THAT(refusal({"delay=2min"}), HasSubstr("up to 60s"));
  EXPECT_THAT(refusal({"rate=1bit"}), HasSubstr("from 8kbit"));
  EXPECT_THAT(refusal({"rate=nanMbit"}), HasSubstr("from 8kbit"));
  EXPECT_THAT(refusal({"loss=nan"}), HasSubstr("requires a share"));
  EXPECT_THAT(refusal({"cut", "direction=up"}), HasSubstr("cut affects both directions"));
  EXPECT_THAT(refusal({"loss=1%", "direction=left"}), HasSubstr("not \"left\""));
}

}  // namespace quality_test
}  // namespace timsctl::sim

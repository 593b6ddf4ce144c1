#include "router/config/unknown.h"

#include <gtest/gtest.h>

namespace tims::config {
namespace {

TEST(Unknown, TablesAreThoseOfOptions) {
  EXPECT_TRUE(is_table("tcp"));
  EXPECT_FALSE(is_table("link"));
  EXPECT_FALSE(is_table("tcp.listen"));
}

TEST(Unknown, KeysAreToldTheNearestOrTheSameNameElsewhere) {
  EXPECT_EQ(unknown_key("tcp.listn"), "unknown key tcp.listn; did you mean tcp.listen?");
  EXPECT_EQ(unknown_key("links"), "unknown key links; did you mean link?");
  EXPECT_EQ(unknown_key("router.faults"), "unknown key router.faults; did you mean sim.faults?");
  EXPECT_EQ(unknown_key("tcp.flux"), "unknown key tcp.flux");
}

TEST(Unknown, TablesAreShownWithTheBracketsOfWhatIsMeant) {
  EXPECT_EQ(unknown_table("tpc", true), "unknown table [[tpc]]; did you mean [tcp]?");
  EXPECT_EQ(unknown_table("links", false), "unknown table [links]; did you mean [[link]]?");
  EXPECT_TRUE(
      unknown_table("flux", true).starts_with("unknown table [[flux]]; known are router, "));
}

TEST(Unknown, AmongEquallyNearTablesTheOneOfTheSameFormIsMeant) {
  EXPECT_EQ(unknown_table("routes", true), "unknown table [[routes]]; did you mean [[route]]?");
  EXPECT_EQ(unknown_table("routes", false), "unknown table [routes]; did you mean [router]?");
}

TEST(Unknown, KeysOfItemsAreTheItemsOnly) {
  const List& link = *find_list("link");
  EXPECT_EQ(unknown_item_key(link, "too"), "unknown key link.too; did you mean link.to?");
  EXPECT_EQ(unknown_item_key(*find_list("route"), "listen"),
            "unknown key route.listen; known are match, via");
}

}  // namespace
}  // namespace tims::config

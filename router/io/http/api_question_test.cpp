#include "router/io/http/api_question.h"

#include <gtest/gtest.h>

#include "router/io/admin_question.h"

namespace tims::io {
namespace {

TEST(ApiQuestion, ArgumentsAreTextsAndNumbers) {
  EXPECT_EQ(api_question("status", ""), R"({"ask":"status"})");
  EXPECT_EQ(api_question("mailboxes", "match=Ladar(*/*)&limit=10"),
            R"json({"match":"Ladar(*/*)","limit":10,"ask":"mailboxes"})json");
  EXPECT_EQ(api_question("route", "to=12&type=-6"), R"({"to":"12","type":-6,"ask":"route"})");
}

TEST(ApiQuestion, EscapesAreDecoded) {
  EXPECT_EQ(api_question("routes", "match=Ladar%283%2f0%29&after=a+b%2B"),
            R"json({"match":"Ladar(3/0)","after":"a b+","ask":"routes"})json");
  EXPECT_EQ(api_question("ping", "pad=%22%7D"), R"({"pad":"\"}","ask":"ping"})");
  EXPECT_EQ(api_question("pin%67", "%70ad=%ff"), R"({"pad":"?","ask":"ping"})");
}

TEST(ApiQuestion, BrokenEscapes) {
  for (const auto* query : {"pad=%", "pad=%2", "pad=%2x", "pad=%x2", "%=1", "pad=%-1", "pad=%+1"})
    EXPECT_EQ(api_question("ping", query), std::nullopt) << query;
  EXPECT_EQ(api_question("st%atus", ""), std::nullopt);
}

TEST(ApiQuestion, OddQueries) {
  EXPECT_EQ(api_question("ping", "&&pad&"), R"({"pad":"","ask":"ping"})");
  EXPECT_EQ(api_question("ping", "pad=a=b"), R"({"pad":"a=b","ask":"ping"})");
  EXPECT_EQ(api_question("ping", "pad=1&pad=2"), R"({"pad":"2","ask":"ping"})");
  EXPECT_EQ(api_question("clients", "limit=ten"), R"({"limit":"ten","ask":"clients"})");
}

// The path says what is asked, whatever the query says.
TEST(ApiQuestion, TheQueryCannotAskForSomethingElse) {
  EXPECT_EQ(api_question("ping", "ask=config"), R"({"ask":"ping"})");
}

TEST(ApiQuestion, EveryNumberIsTakenAsOne) {
  for (const auto& [ask, query] :
       {std::pair("clients", "limit=5"), std::pair("events", "since=5"),
        std::pair("events", "wait_ms=5"), std::pair("route", "to=5&type=5")}) {
    const auto question = parse_question(*api_question(ask, query), {});
    EXPECT_TRUE(std::holds_alternative<Question>(question)) << query;
  }
}

}  // namespace
}  // namespace tims::io

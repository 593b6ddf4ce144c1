#include "router/io/admin_answers.h"

#include <map>

#include <boost/json/parse.hpp>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "router/io/admin_fixture.h"

namespace tims::io {
namespace admin_answers_test {

namespace json = boost::json;
using test::AdminFixture;
using test::ask;
using test::error_code;
using test::text;

TEST(Admin, EveryAnswerSaysWhatItIs) {
  const AdminFixture lab;
  const std::pair<const char*, const char*> cases[] = {
      {R"({"ask":"status"})", "tims/status/1"},
      {R"({"ask":"clients"})", "tims/client/1"},
      {R"({"ask":"routes"})", "tims/route/1"},
      {R"x({"ask":"route","to":"Ladar(3/0)"})x", "tims/route_get/1"},
      {R"({"ask":"mailboxes"})", "tims/mailbox/1"},
      {R"({"ask":"stats"})", "tims/stats/1"},
      {R"({"ask":"events"})", "tims/event/1"},
      {R"({"ask":"config"})", "tims/config/1"},
      {R"({"ask":"ping"})", "tims/ping/1"},
      {R"({"ask":"routers"})", "tims/router_list/1"},
      {R"({"ask":"links"})", "tims/link/1"},
      {R"({"ask":"newest"})", "tims/newest/1"},
      {R"({"ask":"streams"})", "tims/stream/1"},
      {R"({"ask":"leases"})", "tims/lease/1"},
  };
  for (const auto& [question, schema] : cases) {
    const auto answer = ask(lab, question);
    EXPECT_EQ(text(answer.at("schema")), schema) << question;
    EXPECT_EQ(text(answer.at("router")), "lab");
    EXPECT_EQ(text(answer.at("time")), "2027-01-15T08:01:40.000000Z");
    EXPECT_FALSE(answer.at("partial").as_bool());
  }
}

// The agent beside a router is asked past it; guests may only read there.
TEST(Admin, GuestsOnlyReadFromTheAgent) {
  for (const std::string_view reads :
       {"conf_list", "conf_get", "conf_options", "conf_describe", "conf_state", "conf_check",
        "conf_history", "conf_generation", "conf_fleet"})
    EXPECT_TRUE(is_agent_reading(fmt::format(R"({{"ask":"{}","edits":[[[[[[1]]]]]]}})", reads)));
  for (const std::string_view others :
       {R"({"ask":"conf_apply"})", R"({"ask":"conf_lock"})", R"({"ask":"conf_unlock"})",
        R"({"ask":"conf_confirm"})", R"({"ask":"conf_undo"})", R"({"ask":"conf_peer"})",
        R"({"ask":"conf_get","ask":"conf_apply"})", R"({"ask":"conf_new"})", R"({"ask":"status"})",
        R"({"ask":7})", R"(["conf_get"])", "{", "", "conf_get"})
    EXPECT_FALSE(is_agent_reading(others)) << others;
  EXPECT_TRUE(is_agent_agreeing(R"({"ask":"conf_peer","change":"1"})"));
  for (const std::string_view others : {R"({"ask":"conf_undo"})", R"({"ask":["conf_peer"]})", "{"})
    EXPECT_FALSE(is_agent_agreeing(others)) << others;
}

TEST(Admin, StatsSumUpMailboxes) {
  EXPECT_EQ(
      ask(AdminFixture(), R"({"ask":"stats"})").at("mailboxes"),
      (json::value{
          {"received", 1000}, {"replaced", 4}, {"refused", 3}, {"too_big", 2}, {"reclaimed", 1}}));
}

TEST(Admin, WhatChangesSomethingIsNotAskedByWebPages) {
  const AdminFixture lab;
  for (const char* question :
       {R"({"ask":"link","link":"base","do":"down"})", R"({"ask":"fault","loss":0.1})",
        R"x({"ask":"route_add","match":"Ladar(3/*)","via":"robot3"})x",
        R"({"ask":"lease","robot":3,"do":"take","name":"page"})"})
    EXPECT_EQ(error_code(ask(lab, question)), "denied") << question;
}

TEST(Admin, ArgumentsOfActionsAreChecked) {
  const AdminFixture lab;
  for (const char* question :
       {R"({"ask":"link","link":"base"})", R"({"ask":"link","do":"up"})",
        R"({"ask":"link","link":"base","do":"dance"})", R"({"ask":"fault","loss":1.1})",
        R"({"ask":"fault","delay_s":61})", R"({"ask":"route_del"})"})
    EXPECT_EQ(error_code(ask(lab, question)), "bad_argument") << question;
}

TEST(Admin, NewestValuesAreListedAndReadWithTheirAge) {
  AdminFixture lab;
  std::vector<std::byte> bytes(kHeaderSize + 2, std::byte{0x5A});
  lab.pass_sample(60, bytes);
  std::vector<std::byte> status(kHeaderSize);
  lab.pass_sample(90, status, type::kEnabled);
  const auto list = ask(lab, R"x({"ask":"newest","match":"Ladar(*/*)"})x");
  ASSERT_EQ(list.at("items").as_array().size(), 2U);
  EXPECT_EQ(list.at("values"), 2);
  EXPECT_EQ(list.at("items").at(0).at("age_s"), 40.0);
  EXPECT_EQ(text(list.at("items").at(1).at("stream")), "status");
  const auto value = ask(lab, R"x({"ask":"newest","of":"Ladar(3/0)"})x");
  EXPECT_EQ(text(value.at("schema")), "tims/newest_value/1");
  EXPECT_EQ(text(value.at("body")), "5a5a");
  EXPECT_EQ(value.at("type"), type::kData);
  EXPECT_EQ(value.at("little_endian"), std::endian::native == std::endian::little);
  const auto of_status = ask(lab, R"x({"ask":"newest","of":"Ladar(3/0)","stream":"status"})x");
  EXPECT_EQ(of_status.at("type"), type::kEnabled);
  EXPECT_EQ(error_code(ask(lab, R"x({"ask":"newest","of":"Ladar(3/1)"})x")), "none_kept");
  EXPECT_EQ(error_code(ask(lab, R"x({"ask":"newest","of":"Ladar(3/0)","stream":"x"})x")),
            "bad_argument");
}

TEST(Admin, ListsThatAreMadeForAQuestionHavePages) {
  AdminFixture lab;
  std::vector<std::byte> bytes(kHeaderSize);
  lab.pass_sample(60, bytes);
  lab.pass_sample(61, bytes, type::kDisabled);
  const auto first = ask(lab, R"({"ask":"newest","limit":1})");
  EXPECT_EQ(first.at("items").as_array().size(), 1U);
  EXPECT_EQ(text(first.at("next")), "1");
  const auto second = ask(lab, R"({"ask":"newest","limit":1,"after":"1"})");
  EXPECT_EQ(text(second.at("items").at(0).at("stream")), "status");
  EXPECT_FALSE(second.contains("next"));
}

// The largest value that newest.message permits.
TEST(Admin, TheAnswerWithALargeValueFits) {
  AdminFixture lab;
  lab.keep_up_to(112 << 10);
  std::vector<std::byte> bytes(112 << 10, std::byte{0xFF});
  lab.pass_sample(60, bytes);
  const auto answer =
      answer_admin(R"x({"ask":"newest","of":"Ladar(3/0)"})x", lab, AdminFixture::clocks());
  EXPECT_LE(answer.size(), kAnswerBytesMax);
  EXPECT_GT(answer.size(), (224U << 10) - 2 * kHeaderSize);
}

TEST(Admin, StreamsOfAClientThatKeepsTheNewest) {
  AdminFixture lab;
  EXPECT_TRUE(ask(lab, R"({"ask":"streams"})").at("items").as_array().empty());
  std::vector<std::byte> bytes(kHeaderSize + 8);
  bytes[kHeaderSize] = std::byte{3};
  bytes[kHeaderSize + 7] = std::byte{1};
  core::Message login{.header = {.flags = 0, .type = 13, .length = 24}, .bytes = bytes};
  lab.router().on_message(AdminFixture::at(50), lab.pilot(), login);
  const auto streams = ask(lab, R"({"ask":"streams"})");
  ASSERT_EQ(streams.at("items").as_array().size(), 1U);
  EXPECT_EQ(text(streams.at("items").at(0).at("from").at("name")), "Ladar(3/0)");
  EXPECT_EQ(streams.at("items").at(0).at("samples"), 1);
  EXPECT_TRUE(ask(lab, R"x({"ask":"streams","to":"Ladar(3/0)"})x").at("items").as_array().empty());
}

TEST(Admin, StatusCountsAndListsTheLastEvents) {
  const AdminFixture lab;
  const auto status = ask(lab, R"({"ask":"status"})");
  EXPECT_EQ(text(status.at("address").at("name")), "Tims(3/1)");
  EXPECT_EQ(text(status.at("epoch")), "0000000000000abc");
  EXPECT_EQ(status.at("clients"), 2);
  EXPECT_EQ(status.at("mailboxes"), 2);
  EXPECT_TRUE(status.at("listen").at("tcp").is_null());
  EXPECT_TRUE(status.at("udp").is_null()) << "no links, no socket";
  ASSERT_EQ(status.at("events").as_array().size(), 4U);
  const auto& last = status.at("events").at(3);
  EXPECT_EQ(text(last.at("text")), "Pilot(3/0) registered by 127.0.0.1:50000");
  EXPECT_EQ(text(last.at("time")), "2027-01-15T08:00:40.000000Z") << "60 seconds before the answer";
}

TEST(Admin, MailboxesHaveOwnersAndLocalOnesTheirFill) {
  const AdminFixture lab;
  const auto answer = ask(lab, R"({"ask":"mailboxes"})");
  const auto& items = answer.at("items").as_array();
  ASSERT_EQ(items.size(), 2U);
  EXPECT_EQ(text(items[0].at("address").at("raw")), "0x03140000");
  EXPECT_EQ(text(items[0].at("owner").at("name")), "laser");
  EXPECT_EQ(items[0].at("owner").at("pid"), 811);
  EXPECT_EQ(items[0].at("waiting"), 3);
  EXPECT_EQ(items[0].at("age_s").to_number<double>(), 70);
  EXPECT_TRUE(items[1].at("owner").at("name").is_null());
  EXPECT_FALSE(items[1].as_object().contains("waiting")) << "nobody sees into a TCP client";
}

TEST(Admin, MatchSelects) {
  const AdminFixture lab;
  EXPECT_EQ(ask(lab, R"x({"ask":"routes","match":"Pilot(*/*)"})x").at("items").as_array().size(),
            1U);
  EXPECT_TRUE(
      ask(lab, R"x({"ask":"routes","match":"Camera(*/*)"})x").at("items").as_array().empty());
}

TEST(Admin, RouteAsksTheCodeThatForwards) {
  const AdminFixture lab;
  const auto yes = ask(lab, R"x({"ask":"route","to":"Ladar(3/0)","from":"Pilot(3/0)"})x");
  EXPECT_EQ(text(yes.at("verdict")), "deliver");
  EXPECT_EQ(text(yes.at("via")), "local");
  EXPECT_TRUE(yes.at("from_registered").as_bool());
  const auto no = ask(lab, R"({"ask":"route","to":"0x03150000","type":3})");
  EXPECT_EQ(text(no.at("verdict")), "no_route");
  EXPECT_TRUE(no.at("not_available").as_bool());
  const auto data = ask(lab, R"({"ask":"route","to":"0x03150000","type":-6})");
  EXPECT_FALSE(data.at("not_available").as_bool()) << "data to nobody is dropped";
  EXPECT_EQ(text(ask(lab, R"x({"ask":"route","to":"Tims(3/1)"})x").at("verdict")), "self");
}

TEST(Admin, PagesJoinToTheWhole) {
  AdminFixture lab;
  for (std::uint32_t i = 0; i < 50; ++i)
    lab.router().register_mailbox(AdminFixture::at(50), lab.laser(), Address(0x03100000 + i));
  std::string after;
  std::vector<std::string> seen;
  for (int page = 0; page < 20; ++page) {
    const auto answer = ask(lab, R"({"ask":"routes","limit":7,"after":")" + after + "\"}");
    for (const auto& item : answer.at("items").as_array())
      seen.emplace_back(text(item.at("address").at("raw")));
    if (!answer.contains("next")) break;
    after = text(answer.at("next"));
  }
  EXPECT_EQ(seen.size(), 52U);
  EXPECT_TRUE(std::ranges::is_sorted(seen));
}

TEST(Admin, ClientsComeInPagesToo) {
  const AdminFixture lab;
  const auto first = ask(lab, R"({"ask":"clients","limit":1})");
  ASSERT_EQ(first.at("items").as_array().size(), 1U);
  const std::string next(text(first.at("next")));
  const auto second = ask(lab, R"({"ask":"clients","limit":1,"after":")" + next + "\"}");
  EXPECT_EQ(text(second.at("items").at(0).at("peer")), "127.0.0.1:50000");
  EXPECT_EQ(second.at("items").at(0).at("queue_bytes"), 512);
  EXPECT_FALSE(second.contains("next"));
}

TEST(Admin, AnswersAreBounded) {
  AdminFixture lab;
  for (std::uint32_t i = 0; i < 3000; ++i)
    lab.router().register_mailbox(AdminFixture::at(50), lab.laser(), Address(0x03100000 + i), 7);
  const std::string answer = answer_admin(R"({"ask":"mailboxes"})", lab, AdminFixture::clocks());
  EXPECT_LE(answer.size(), kAnswerBytesMax);
  const auto parsed = json::parse(answer).as_object();
  EXPECT_GT(parsed.at("items").as_array().size(), 100U);
  EXPECT_TRUE(parsed.contains("next"));
}

// As many static routes as there may be, with the longest names.
TEST(Admin, AnswersWithStaticRoutesAreBounded) {
  AdminFixture lab;
  for (std::uint32_t i = 0; i < 3000; ++i)
    lab.router().register_mailbox(AdminFixture::at(50), lab.laser(), Address(0x03100000 + i), 7);
  const std::string name(63, '"');  // each of them two characters in JSON
  lab.router().set_static_routes(std::vector<core::StaticRoute>(
      2 * kStaticRoutesMax, {.text = std::string_view(name), .via = std::string_view(name)}));
  const std::string answer = answer_admin(R"({"ask":"routes"})", lab, AdminFixture::clocks());
  EXPECT_LE(answer.size(), kAnswerBytesMax);
  const auto parsed = json::parse(answer).as_object();
  EXPECT_EQ(parsed.at("static").as_array().size(), kStaticRoutesMax);
  EXPECT_GT(parsed.at("items").as_array().size(), 100U);
  EXPECT_TRUE(parsed.contains("next"));
}

TEST(Admin, ConfigListsOrigins) {
  const AdminFixture lab;
  bool found = false;
  const auto answer = ask(lab, R"({"ask":"config"})");
  for (const auto& item : answer.at("items").as_array()) {
    if (text(item.at("key")) != "router.name") continue;
    found = true;
    EXPECT_EQ(text(item.at("value")), "\"lab\"");
    EXPECT_EQ(text(item.at("origin")), "--set 1");
  }
  EXPECT_TRUE(found);
}

TEST(Admin, ConfigListsLinksAndRoutes) {
  AdminFixture lab;
  lab.configure({"link=kind=super,to=127.0.0.1", "route=match=Ladar(3/*),via=robot2"});
  std::map<std::string, std::string> values;
  const auto answer = ask(lab, R"({"ask":"config"})");
  for (const auto& item : answer.at("items").as_array())
    values.emplace(text(item.at("key")),
                   fmt::format("{} {}", text(item.at("value")), text(item.at("origin"))));
  EXPECT_EQ(values["link[0].kind"], "\"super\" --set 1");
  EXPECT_EQ(values["link[0].to"], "\"127.0.0.1:2010\" --set 1");
  EXPECT_EQ(values["link[0].interval"], "\"300ms\" default");
  EXPECT_EQ(values.count("link[0].system"), 0U);
  EXPECT_EQ(values["route[0].via"], "\"robot2\" --set 2");
}

TEST(Admin, PingGivesThePadBack) {
  const AdminFixture lab;
  EXPECT_EQ(text(ask(lab, R"({"ask":"ping","pad":"xyz"})").at("pad")), "xyz");
}

TEST(Admin, WrongQuestionsAreAnsweredWithTheReason) {
  const AdminFixture lab;
  const std::pair<std::string, const char*> cases[] = {
      {"", "bad_json"},
      {"{", "bad_json"},
      {std::string("\0\xff\xfe", 3), "bad_json"},
      {std::string(100'000, '['), "bad_json"},
      {std::string(70'000, ' '), "bad_json"},
      {R"({"ask":[[[[[1]]]]]})", "bad_json"},
      {"{\"ask\":\"\xc3\x28\"}", "bad_json"},
      {"[]", "bad_question"},
      {"null", "bad_question"},
      {"{}", "bad_question"},
      {R"({"ask":7})", "bad_question"},
      {R"({"ask":"everything"})", "unknown_question"},
      {R"({"ask":"status","limit":5})", "bad_argument"},
      {R"({"ask":"routes","limit":0})", "bad_argument"},
      {R"({"ask":"routes","limit":1e300})", "bad_argument"},
      {R"({"ask":"routes","limit":18446744073709551615})", "bad_argument"},
      {R"({"ask":"routes","limit":-1})", "bad_argument"},
      {R"({"ask":"routes","match":"Ladar("})", "bad_argument"},
      {R"({"ask":"routes","match":3})", "bad_argument"},
      {R"({"ask":"route"})", "bad_argument"},
      {R"({"ask":"status","":1})", "bad_argument"},
      {R"x({"ask":"route","to":"Ladar(3/0)","type":128})x", "bad_argument"},
      {R"({"ask":"events","wait_ms":30001})", "bad_argument"},
      {R"({"ask":"events","since":-1})", "bad_argument"},
  };
  for (const auto& [question, code] : cases)
    EXPECT_EQ(error_code(ask(lab, question)), code) << question.substr(0, 80);
}

TEST(Admin, NamesThatAreNoTextStillMakeJson) {
  AdminFixture lab;
  lab.router().connect(
      AdminFixture::at(50),
      {.port = core::PortKind::kLocal, .name = std::string_view("\xff\x1b[2J\"\\\xed\xa0\x80")});
  const auto answer = ask(lab, R"({"ask":"clients"})");
  EXPECT_EQ(text(answer.at("items").at(2).at("name")), "?\x1b[2J\"\\???");
}

TEST(Admin, EventsSinceANumber) {
  const AdminFixture lab;
  const auto none = ask(lab, R"({"ask":"events"})");
  EXPECT_TRUE(none.at("items").as_array().empty());
  EXPECT_EQ(none.at("last"), 4);
  const auto some = ask(lab, R"({"ask":"events","since":1,"limit":2})");
  ASSERT_EQ(some.at("items").as_array().size(), 2U);
  EXPECT_EQ(some.at("items").at(0).at("seq"), 2);
  EXPECT_EQ(some.at("last"), 3) << "the number to go on with, not the newest there is";
}

}  // namespace admin_answers_test
}  // namespace tims::io

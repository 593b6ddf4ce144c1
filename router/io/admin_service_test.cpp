#include "router/io/admin_service.h"

#include <cstring>
#include <map>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "router/io/admin_fixture.h"
#include "wire/header.h"

namespace tims::io {
namespace admin_service_test {

namespace json = boost::json;
using test::AdminFixture;

json::object ask(const AdminFixture& lab, std::string_view question) {
  return json::parse(answer_admin(question, lab, AdminFixture::clocks())).as_object();
}
std::string_view error_code(const json::object& answer) {
  return answer.at("error").at("code").as_string();
}
std::string_view text(const json::value& value) { return value.as_string(); }

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
  EXPECT_GT(answer.size(), 2U * (112 << 10) - 2 * kHeaderSize);
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

// --- questions that wait

struct Answers {
  std::vector<std::pair<core::ClientId, json::object>> all;
  AdminService::Send keep() {
    return [this](core::ClientId asker, core::Message& message) {
      const auto body = message.body();
      const std::string_view text(reinterpret_cast<const char*>(body.data()), body.size());
      all.emplace_back(asker, json::parse(text).as_object());
      headers.push_back(
          wire::decode_header(wire::ConstHeaderBytes(message.bytes.first<kHeaderSize>())));
    };
  }
  std::vector<Header> headers;
};

void put_question(AdminService& service, core::ClientId from, std::string_view question) {
  std::vector<std::byte> bytes(kHeaderSize + question.size());
  std::memcpy(bytes.data() + kHeaderSize, question.data(), question.size());
  const core::Message message{.header = {.type = type::kAdminRequest,
                                         .priority = 9,
                                         .seq_nr = 5,
                                         .dest = Address(0x03000100),
                                         .src = Address(0x030F0102),
                                         .length = static_cast<std::uint32_t>(bytes.size())},
                              .bytes = bytes};
  service.ask(AdminFixture::at(100), from, message);
}

constexpr std::string_view kEventsQuestion = R"({"ask":"events","since":4,"wait_ms":10000})";

// While it needs turns.
void answer_all(AdminService& service, Answers& answers) {
  do {
    service.answer(AdminFixture::clocks(), answers.keep());
  } while (service.needs_turn());
}

TEST(AdminService, AnswersWithTheQuestionsAddressesPriorityAndNumber) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  put_question(service, lab.laser(), R"({"ask":"ping"})");
  service.answer(AdminFixture::clocks(), answers.keep());
  ASSERT_EQ(answers.all.size(), 1U);
  EXPECT_EQ(answers.all[0].first, lab.laser());
  const Header& header = answers.headers[0];
  EXPECT_EQ(header.type, type::kAdminReply);
  EXPECT_EQ(header.dest, Address(0x030F0102));
  EXPECT_EQ(header.src, Address(0x03000100));
  EXPECT_EQ(header.priority, 9);
  EXPECT_EQ(header.seq_nr, 5);
  EXPECT_EQ(service.next_timeout(), kNever);
}

TEST(AdminService, AQuestionForEventsWaitsForOne) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  put_question(service, lab.laser(), R"({"ask":"events","since":4,"wait_ms":10000})");
  service.answer(AdminFixture::clocks(), answers.keep());
  EXPECT_TRUE(answers.all.empty());
  EXPECT_EQ(service.next_timeout(), AdminFixture::at(110));
  lab.router().register_mailbox(AdminFixture::at(103), lab.pilot(), Address(0x03180001));
  service.event_happened();
  service.answer(AdminFixture::clocks(103), answers.keep());
  ASSERT_EQ(answers.all.size(), 1U);
  EXPECT_EQ(text(answers.all[0].second.at("items").at(0).at("kind")), "registered");
  EXPECT_EQ(answers.all[0].second.at("last"), 5);
}

TEST(AdminService, TheWaitEnds) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  put_question(service, lab.laser(), R"({"ask":"events","since":4,"wait_ms":10000})");
  service.answer(AdminFixture::clocks(109), answers.keep());
  EXPECT_TRUE(answers.all.empty());
  service.answer(AdminFixture::clocks(110), answers.keep());
  ASSERT_EQ(answers.all.size(), 1U);
  EXPECT_TRUE(answers.all[0].second.at("items").as_array().empty());
  EXPECT_EQ(answers.all[0].second.at("last"), 4);
}

TEST(AdminService, ANumberFromBeforeARestartIsAnsweredAtOnce) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  put_question(service, lab.laser(), R"({"ask":"events","since":99,"wait_ms":10000})");
  service.answer(AdminFixture::clocks(), answers.keep());
  ASSERT_EQ(answers.all.size(), 1U);
  EXPECT_EQ(answers.all[0].second.at("items").as_array().size(), 4U);
}

TEST(AdminService, ANumberOfAnotherEpochIsAnsweredAtOnceWithEverything) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  put_question(service, lab.laser(),
               R"({"ask":"events","since":4,"epoch":"0000000000000abd","wait_ms":10000})");
  service.answer(AdminFixture::clocks(), answers.keep());
  ASSERT_EQ(answers.all.size(), 1U);
  EXPECT_EQ(answers.all[0].second.at("items").as_array().size(), 4U);
  EXPECT_EQ(text(answers.all[0].second.at("epoch")), "0000000000000abc");
}

TEST(AdminService, ANumberOfThisEpochWaits) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  put_question(service, lab.laser(),
               R"({"ask":"events","since":4,"epoch":"0000000000000abc","wait_ms":10000})");
  service.answer(AdminFixture::clocks(), answers.keep());
  EXPECT_TRUE(answers.all.empty());
}

TEST(AdminService, ADisconnectedClientGetsNoAnswer) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  put_question(service, lab.laser(), R"({"ask":"events","since":4,"wait_ms":10000})");
  lab.router().disconnect(AdminFixture::at(101), lab.laser(), core::CloseReason::kPeerClosed);
  service.event_happened();
  service.answer(AdminFixture::clocks(101), answers.keep());
  EXPECT_TRUE(answers.all.empty());
  EXPECT_EQ(service.next_timeout(), kNever);
}

TEST(AdminService, WaitingQuestionsAreBounded) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  std::vector<core::ClientId> clients;
  for (std::size_t i = 0; i < AdminService::kWaitingMax / AdminService::kPerClientMax; ++i)
    clients.push_back(lab.router().connect(AdminFixture::at(100), {}));
  const std::string question =
      fmt::format(R"({{"ask":"events","since":{},"wait_ms":10000}})", lab.router().events().last());
  for (std::size_t i = 0; i < AdminService::kWaitingMax; ++i)
    put_question(service, clients[i % clients.size()], question);
  answer_all(service, answers);
  EXPECT_TRUE(answers.all.empty()) << "all of them wait";
  for (int i = 0; i < 3; ++i) put_question(service, lab.laser(), question);
  answer_all(service, answers);
  EXPECT_EQ(answers.all.size(), 3U) << "the oldest make room";
  EXPECT_FALSE(service.has_work(AdminFixture::at(109)));
}

TEST(AdminService, AClientHasABoundedNumberOfQuestions) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  for (std::size_t i = 0; i < AdminService::kPerClientMax + 2; ++i)
    put_question(service, lab.laser(), kEventsQuestion);
  put_question(service, lab.pilot(), R"({"ask":"ping"})");
  service.answer(AdminFixture::clocks(), answers.keep());
  ASSERT_EQ(answers.all.size(), 3U);
  EXPECT_EQ(error_code(answers.all[0].second), "busy");
  EXPECT_EQ(error_code(answers.all[1].second), "busy");
  EXPECT_EQ(answers.headers[1].seq_nr, 5);
  EXPECT_EQ(answers.all[2].first, lab.pilot());
}

// One client's large answers, and another client's small one in between.
TEST(AdminService, LargeAnswersDelayOnlyTheirOwnClient) {
  AdminFixture lab;
  for (std::uint32_t i = 0; i < 2000; ++i)
    lab.router().register_mailbox(AdminFixture::at(50), lab.laser(), Address(0x03100000 + i));
  AdminService service(lab);
  Answers answers;
  for (int i = 0; i < 5; ++i) put_question(service, lab.laser(), R"({"ask":"routes"})");
  put_question(service, lab.pilot(), R"({"ask":"ping"})");
  service.answer(AdminFixture::clocks(), answers.keep());
  EXPECT_EQ(answers.all.size(), 2U) << "one each";
  EXPECT_EQ(answers.all.back().first, lab.pilot());
  EXPECT_TRUE(service.needs_turn());
  EXPECT_EQ(service.next_timeout(), kNever) << "it asks for its turn";
  answer_all(service, answers);
  EXPECT_EQ(answers.all.size(), 6U);
}

TEST(AdminService, ATurnMakesABoundedNumberOfBytes) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  const std::string pad(kQuestionBytesMax - 100, 'x');
  std::vector<core::ClientId> clients;
  for (int i = 0; i < 6; ++i) {
    clients.push_back(lab.router().connect(AdminFixture::at(100), {}));
    for (int n = 0; n < 2; ++n)
      put_question(service, clients.back(), R"({"ask":"ping","pad":")" + pad + "\"}");
  }
  service.answer(AdminFixture::clocks(), answers.keep());
  EXPECT_EQ(answers.all.size(), 4U) << "no further one when 256 KiB are made";
  service.answer(AdminFixture::clocks(), answers.keep());
  ASSERT_EQ(answers.all.size(), 6U);
  EXPECT_EQ(answers.all[4].first, clients[4]) << "clients without an answer come first";
  answer_all(service, answers);
  EXPECT_EQ(answers.all.size(), 12U);
}

TEST(AdminService, GuestsChangeNothingUnlessAllowed) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  const std::string_view question = R"({"ask":"route_del","match":"*"})";
  put_question(service, lab.pilot(), question);
  put_question(service, lab.laser(), question);
  answer_all(service, answers);
  ASSERT_EQ(answers.all.size(), 2U);
  EXPECT_EQ(error_code(answers.all[0].second), "denied") << "over TCP";
  EXPECT_EQ(error_code(answers.all[1].second), "not_done") << "from this host";
  lab.configure({"tcp.admin=true"});
  put_question(service, lab.pilot(), question);
  answer_all(service, answers);
  EXPECT_EQ(error_code(answers.all[2].second), "not_done");
}

TEST(AdminService, GuestsMayTakeTheDrivingLease) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  const auto ask_as = [&](core::ClientId client, std::string_view question) {
    put_question(service, client, question);
    answer_all(service, answers);
    return answers.all.back().second;
  };
  const char* take =
      R"x({"ask":"lease","robot":3,"do":"take","name":"tablet","stick":"Joystick(3/0)"})x";
  EXPECT_EQ(ask_as(lab.pilot(), take).at("left_s"), 5.0);
  const auto taken = ask_as(lab.laser(), R"({"ask":"lease","robot":3,"do":"take","name":"desk"})");
  EXPECT_EQ(error_code(taken), "lease_taken");
  EXPECT_EQ(text(taken.at("error").at("message")), "tablet drives robot 3");
  EXPECT_EQ(error_code(ask_as(lab.laser(), R"({"ask":"lease","robot":3,"do":"renew"})")),
            "lease_not_held");
  const auto leases = ask(lab, R"({"ask":"leases"})");
  ASSERT_EQ(leases.at("items").as_array().size(), 1U);
  EXPECT_EQ(text(leases.at("items").at(0).at("holder")), "tablet");
  EXPECT_EQ(text(leases.at("items").at(0).at("stick").at("name")), "Joystick(3/0)");
  ask_as(lab.laser(), R"({"ask":"lease","robot":3,"do":"take_over","name":"desk"})");
  EXPECT_EQ(error_code(ask_as(lab.pilot(), R"({"ask":"lease","robot":3,"do":"release"})")),
            "lease_not_held");
  EXPECT_TRUE(ask_as(lab.laser(), R"({"ask":"lease","robot":3,"do":"release"})").contains("done"));
  EXPECT_EQ(text(ask_as(lab.pilot(), R"({"ask":"lease","robot":3,"do":"renew"})")
                     .at("error")
                     .at("message")),
            "the driving lease of robot 3 has ended");
}

// A client of a subsystem router reaches components there without passing the system router.
TEST(AdminService, TheOtherRoutersOfARobotAreToldWhoDrives) {
  AdminFixture lab;
  const auto link = [&](core::LinkKind kind, std::uint16_t system, std::uint8_t id) {
    lab.router().connect(AdminFixture::at(50),
                         {.port = core::PortKind::kLink,
                          .link = {.kind = kind,
                                   .role = core::Role::kSubsystem,
                                   .system = system,
                                   .router = Address::of({.system = system, .instance = id})}});
  };
  link(core::LinkKind::kSub, 3, 2);
  link(core::LinkKind::kSub, 4, 2);
  link(core::LinkKind::kPeer, 3, 3);
  AdminService service(lab);
  Answers answers;
  put_question(service, lab.laser(),
               R"x({"ask":"lease","robot":3,"do":"take","name":"desk","stick":"Joystick(3/0)"})x");
  answer_all(service, answers);
  ASSERT_EQ(answers.all.size(), 2U);
  EXPECT_EQ(answers.headers[1].dest, Address(0x03000200));
  EXPECT_EQ(answers.headers[1].type, type::kAdminRequest);
  EXPECT_EQ(json::serialize(answers.all[1].second),
            R"({"ask":"lease","robot":3,"do":"take_over","mailbox":"0x030f0102","name":"desk",)"
            R"("stick":"0x03170000"})");
  put_question(service, lab.pilot(), R"({"ask":"lease","robot":3,"do":"renew"})");
  answer_all(service, answers);
  EXPECT_EQ(answers.all.size(), 3U) << "nothing has changed";
  put_question(service, lab.laser(), R"({"ask":"lease","robot":3,"do":"release"})");
  answer_all(service, answers);
  ASSERT_EQ(answers.all.size(), 5U);
  EXPECT_EQ(text(answers.all[4].second.at("do")), "release");
}

TEST(AdminService, ASubsystemRouterHasTheLeasesOfTheRouterAboveIt) {
  AdminFixture lab(core::Role::kSubsystem);
  const core::ClientId above =
      lab.router().connect(AdminFixture::at(50), {.port = core::PortKind::kLink,
                                                  .link = {.kind = core::LinkKind::kSuper,
                                                           .role = core::Role::kSystem,
                                                           .system = 3,
                                                           .router = Address(0x03000200)}});
  AdminService service(lab);
  Answers answers;
  const auto ask_as = [&](core::ClientId client, std::string_view question) {
    put_question(service, client, question);
    answer_all(service, answers);
    return answers.all.back().second;
  };
  const char* take = R"({"ask":"lease","robot":3,"do":"take","name":"page"})";
  EXPECT_FALSE(ask_as(lab.pilot(), take).contains("error")) << "nobody is above";
  lab.router().set_uplink(AdminFixture::at(50), above);
  const auto elsewhere = ask_as(lab.pilot(), take);
  EXPECT_EQ(error_code(elsewhere), "lease_elsewhere");
  EXPECT_EQ(text(elsewhere.at("error").at("hint")), "ask Tims(3/2)");
  // The holder is the client with the mailbox, or whoever sends from above.
  for (const auto& [mailbox, holder] :
       {std::pair("Pilot(3/0)", lab.pilot()), std::pair("Tool(0/7)", above)}) {
    EXPECT_FALSE(ask_as(above, fmt::format(R"({{"ask":"lease","robot":3,"do":"take_over","name":)"
                                           R"("x","mailbox":"{}"}})",
                                           mailbox))
                     .contains("error"));
    EXPECT_EQ(lab.router().leases().find(3)->client.id, holder);
  }
}

TEST(AdminService, ALeaseIsCheckedBeforeItIsTaken) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  for (const char* question :
       {R"({"ask":"lease","do":"take","name":"x"})", R"({"ask":"lease","robot":3,"name":"x"})",
        R"({"ask":"lease","robot":3,"do":"take"})", R"({"ask":"lease","robot":3,"do":"steal"})",
        R"({"ask":"lease","robot":256,"do":"take","name":"x"})",
        R"({"ask":"lease","robot":-1,"do":"take","name":"x"})",
        R"({"ask":"lease","robot":3,"do":"take","name":""})",
        R"({"ask":"lease","robot":3,"do":"take","name":"a name of thirty-two bytes, exact"})",
        R"({"ask":"lease","robot":3,"do":"take","name":"x","stick":"here"})"}) {
    put_question(service, lab.laser(), question);
    answer_all(service, answers);
    EXPECT_EQ(error_code(answers.all.back().second), "bad_argument") << question;
  }
  put_question(
      service, lab.laser(),
      R"({"ask":"lease","robot":255,"do":"take","name":"a name of thirty-one bytes, see"})");
  answer_all(service, answers);
  EXPECT_FALSE(answers.all.back().second.contains("error"));
}

// Another router would not see where they come from.
TEST(AdminService, GuestsChangeNoOtherRouter) {
  AdminFixture lab;
  const AdminService service(lab);
  const auto may_ask = [&](core::ClientId from, std::string_view question) {
    std::vector<std::byte> bytes(kHeaderSize + question.size());
    std::memcpy(bytes.data() + kHeaderSize, question.data(), question.size());
    return service.may_ask(from, {.header = {}, .bytes = bytes});
  };
  const std::string_view change = R"({"ask":"link","link":"base","do":"down"})";
  EXPECT_FALSE(may_ask(lab.pilot(), change));
  EXPECT_TRUE(may_ask(lab.laser(), change));
  EXPECT_TRUE(may_ask(lab.pilot(), R"({"ask":"status"})"));
  EXPECT_TRUE(may_ask(lab.pilot(), "nonsense")) << "the other router reports the error";
  lab.configure({"tcp.admin=true"});
  EXPECT_TRUE(may_ask(lab.pilot(), change));
}

TEST(ReloadRoutes, KeepsWhatPeopleHaveChanged) {
  const auto route = [](std::string_view match, std::string_view via) {
    return core::StaticRoute{.match = {}, .text = match, .via = via};
  };
  const auto as_text = [](const std::vector<core::StaticRoute>& routes) {
    std::string text;
    for (const auto& r : routes) text += fmt::format("{}>{} ", r.text.view(), r.via.view());
    return text;
  };
  const auto a = route("a", "x");
  const auto b = route("b", "x");
  const auto c = route("c", "x");
  const auto b_elsewhere = route("b", "y");
  EXPECT_EQ(as_text(reload_routes({a, b, c}, {a, b}, {a, b})), "a>x b>x c>x ") << "c was added";
  EXPECT_EQ(as_text(reload_routes({a, c}, {a, b}, {a, b})), "a>x c>x ") << "b was deleted";
  EXPECT_EQ(as_text(reload_routes({a, b, c}, {a, b}, {b_elsewhere})), "b>y c>x ");
  EXPECT_EQ(as_text(reload_routes({a, b, c}, {a, b}, {c, a})), "c>x a>x ") << "once";
  EXPECT_EQ(as_text(reload_routes({}, {}, {a, b})), "a>x b>x ");
}

TEST(AdminService, AClientThatDoesNotReadItsAnswersGetsNoMore) {
  AdminFixture lab;
  AdminService service(lab);
  Answers answers;
  lab.tcp_queued_bytes = kAnswerBytesMax;
  put_question(service, lab.pilot(), R"({"ask":"ping"})");
  put_question(service, lab.laser(), R"({"ask":"ping"})");
  answer_all(service, answers);
  ASSERT_EQ(answers.all.size(), 1U);
  EXPECT_EQ(answers.all[0].first, lab.laser());
  EXPECT_FALSE(service.needs_turn()) << "nothing to do until it reads";
  EXPECT_TRUE(service.has_work(AdminFixture::at(100)));
  lab.tcp_queued_bytes = kAnswerBytesMax - 1;
  answer_all(service, answers);
  EXPECT_EQ(answers.all.size(), 2U);
}

}  // namespace admin_service_test
}  // namespace tims::io

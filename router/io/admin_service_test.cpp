#include "router/io/admin_service.h"

#include <cstring>

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
using test::ask;
using test::error_code;
using test::text;

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
  EXPECT_EQ(answers.headers[0].dest, Address(0x03000200)) << "before the answer";
  EXPECT_EQ(answers.headers[0].type, type::kAdminRequest);
  EXPECT_EQ(json::serialize(answers.all[0].second),
            R"({"ask":"lease","robot":3,"do":"take_over","mailbox":"0x030f0102","name":"desk",)"
            R"("stick":"0x03170000"})");
  put_question(service, lab.pilot(), R"({"ask":"lease","robot":3,"do":"renew"})");
  answer_all(service, answers);
  EXPECT_EQ(answers.all.size(), 3U) << "nothing has changed";
  put_question(service, lab.laser(), R"({"ask":"lease","robot":3,"do":"release"})");
  answer_all(service, answers);
  ASSERT_EQ(answers.all.size(), 5U);
  EXPECT_EQ(text(answers.all[3].second.at("do")), "release");
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
  EXPECT_FALSE(may_ask(lab.pilot(), "nonsense")) << "the other router might understand it";
  lab.configure({"tcp.admin=true"});
  EXPECT_TRUE(may_ask(lab.pilot(), change));
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

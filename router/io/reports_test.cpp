#include "router/io/reports.h"

#include <fstream>
#include <iterator>
#include <map>

#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "router/io/linked_fixture.h"

namespace tims::io {
namespace reports_test {

namespace json = boost::json;
using test::ask;
using test::LinkedFixture;

// The items of all pages of `limit`, by what they are known as: their name, else where they are.
std::map<std::string, json::object> items(const LinkedFixture& lab, const std::string& question,
                                          int limit = 1000) {
  std::map<std::string, json::object> all;
  std::string after;
  for (int page = 0; page < 20; ++page) {
    const auto answer =
        ask(lab, fmt::format(R"({{"ask":"{}","limit":{},"after":"{}"}})", question, limit, after));
    for (const auto& item : answer.at("items").as_array()) {
      const auto& name = item.at("name").is_null() ? item.at("to") : item.at("name");
      EXPECT_TRUE(all.emplace(name.as_string(), item.as_object()).second)
          << "reported twice: " << name;
    }
    if (!answer.contains("next")) return all;
    after = answer.at("next").as_string();
  }
  ADD_FAILURE() << "pages without end";
  return all;
}

// The fields of a report, in order: "name, address, listen {unix, tcp}".
std::string fields_of(const json::object& report) {
  std::string text;
  for (const auto& [name, value] : report) {
    text.append(text.empty() ? "" : ", ").append(name);
    // The fields of an address are the same everywhere.
    if (const auto* inner = value.if_object(); inner != nullptr && !inner->contains("raw"))
      text.append(" {").append(fields_of(*inner)).append("}");
  }
  return text;
}

// In lines of the document's width.
std::string fields_line(std::string_view what, const json::object& report) {
  constexpr std::size_t kWidth = 110;
  std::string text;
  std::string line = fmt::format("    {}:", what);
  for (std::string rest = fields_of(report); !rest.empty();) {
    const std::string token = rest.substr(0, rest.find(' '));
    rest.erase(0, std::min(rest.size(), token.size() + 1));
    if (line.size() + 1 + token.size() > kWidth) {
      text += line + "\n";
      line = "       ";
    }
    line += " " + token;
  }
  return text + line + "\n";
}

// The field lists in the document must equal those of the reports. No value here is unknown.
TEST(Reports, TheDocumentHasEveryField) {
  const LinkedFixture lab;
  const AddressWidths widths;
  const Time now = LinkedFixture::at(100);
  const link::Links& links = *lab.links();
  const link::Link* link = nullptr;
  links.for_each([&](const link::Link& one) {
    if (link == nullptr && one.is_up()) link = &one;
  });
  ASSERT_NE(link, nullptr);
  const link::Faults faults;
  const json::object link_report = to_json(links, *link, lab.router(), &faults, now);
  ProcessReport process = lab.process(now);
  process.udp_socket = UdpReport();
  process.keys = KeysReport();
  const core::Event event{.owner = {.id = lab.laser()}};
  const std::string lists =
      fields_line("an address", to_json(Address(), widths)) +
      fields_line("tims/status/1", to_json(core::report_status(lab.router(), now), process)) +
      fields_line("tims/client/1", to_json(core::ClientReport())) +
      fields_line("tims/route/1, tims/mailbox/1", to_json(core::MailboxReport(), widths)) +
      fields_line("tims/mailbox/1 of a local one", to_json(MailboxFill())) +
      fields_line("tims/router_list/1, the router itself", to_json(links.self(), process)) +
      fields_line("tims/router_list/1, a neighbour", to_json(*link, now)) +
      fields_line("tims/router_list/1, a missing one",
                  to_json(core::MissingRouter(), widths, now)) +
      fields_line("tims/link/1", link_report) +
      fields_line("paths of tims/link/1", link_report.at("paths").at(0).as_object()) +
      fields_line("dds of tims/fleet/1", to_json(DdsReport())) +
      fields_line("tims/fleet/1", to_json(links, link::Announcement())) +
      fields_line("tims/rule/1", to_json(core::RuleReport())) +
      fields_line("tims/verdict/1", to_json(core::VerdictReport())) +
      fields_line("tims/stats/1", to_json(core::CountReport())) +
      fields_line("mailboxes of tims/stats/1", to_json(shm::Counters())) +
      fields_line("tims/newest/1", to_json(core::NewestValues::Value(), widths, now)) +
      fields_line("tims/newest/1, besides its items", to_json(core::NewestValues::Counts())) +
      fields_line("tims/stream/1", to_json(core::StreamReport(), widths)) +
      fields_line(
          "tims/lease/1",
          to_json(core::DrivingLease{.mailbox = Address(1), .stick = Address(1)}, widths, now)) +
      fields_line("tims/event/1", to_json(event, LinkedFixture::clocks(), widths));
  std::ifstream file(TIMS_ADMIN_FILE);
  const std::string document(std::istreambuf_iterator<char>(file), {});
  EXPECT_NE(document.find("\n\n" + lists + "\n"), std::string::npos)
      << "router/io/ADMIN.md, under \"Fields\":\n\n"
      << lists;
}

TEST(Reports, EveryStateHasAName) {
  const LinkedFixture lab;
  std::map<std::string, std::string> states;
  for (const auto& [name, link] : items(lab, "links")) states[name] = link.at("state").as_string();
  EXPECT_EQ(states, (std::map<std::string, std::string>{{"base", "up"},
                                                        {"arm", "up"},
                                                        {"head", "silent"},
                                                        {LinkedFixture::to_refuser, "refused"},
                                                        {LinkedFixture::to_nobody, "connecting"},
                                                        {LinkedFixture::to_unknown, "idle"},
                                                        {LinkedFixture::to_taken_down, "down"}}));
}

TEST(Reports, ALinkThatIsUpReportsItsSession) {
  const LinkedFixture lab;
  auto link = items(lab, "links").at("base");
  EXPECT_EQ(link.at("kind"), "super");
  EXPECT_EQ(link.at("role"), "top");
  EXPECT_EQ(link.at("peer_address"), LinkedFixture::to_base);
  EXPECT_EQ(link.at("connects"), true);
  EXPECT_EQ(link.at("active"), true);
  EXPECT_TRUE(link.at("refusal").is_null());
  EXPECT_LE(link.at("heard_s").to_number<double>(), 0.4) << "a keep-alive is not longer ago";
  EXPECT_GT(link.at("packets_in").to_number<int>(), 0);
  EXPECT_GT(link.at("wire_bytes_out").to_number<int>(), 0);
  EXPECT_EQ(link.at("queue_bytes").as_array().size(), link::kLanes);
  EXPECT_TRUE(link.at("clock").is_object());
}

TEST(Reports, ALinkThatWasNeverUpReportsItsAttempts) {
  const LinkedFixture lab;
  const auto links = items(lab, "links");
  const json::object& refused = links.at(LinkedFixture::to_refuser);
  EXPECT_EQ(refused.at("refusal"), "Tims(0/3) refuser accepts system 9, not 3");
  for (const char* field : {"peer", "epoch", "address", "heard_s", "rtt_s", "clock"})
    EXPECT_TRUE(refused.at(field).is_null()) << field;
  EXPECT_EQ(refused.at("packets_in"), 0);
  EXPECT_TRUE(links.at(LinkedFixture::to_unknown).at("peer_address").is_null());
}

TEST(Reports, ASilentLinkRemembersItsPeer) {
  const LinkedFixture lab;
  auto link = items(lab, "links").at("head");
  EXPECT_EQ(link.at("connects"), false);
  EXPECT_TRUE(link.at("to").is_null());
  EXPECT_EQ(link.at("address").at("name"), "Tims(3/12)");
  EXPECT_NEAR(link.at("heard_s").to_number<double>(), 40, 1);
  EXPECT_TRUE(link.at("clock").is_null()) << "of a path that is no more";
}

TEST(Reports, TheRouterItselfIsTheFirstOfTheFleet) {
  const LinkedFixture lab;
  const auto answer = ask(lab, R"({"ask":"routers"})");
  const auto& self = answer.at("items").at(0);
  EXPECT_EQ(self.at("kind"), "self");
  EXPECT_EQ(self.at("name"), "lab");
  EXPECT_EQ(answer.at("items").as_array().size(), 8U);
}

TEST(Reports, RoutersThatWentWithTheirLinkAreListedAfterTheOthers) {
  LinkedFixture lab;
  const auto now = LinkedFixture::at(90);
  constexpr Address kTail(0x03000E00);
  constexpr Address kPaw(0x03000F00);
  const core::ClientId tail = lab.router().connect(
      now,
      {.port = core::PortKind::kLink, .name = std::string_view("tail"), .link = {.router = kTail}});
  lab.router().learn(now, tail, kPaw, {kPaw, 7, 2});
  lab.router().learn(now, tail, kTail, {kTail, 6, 1});
  lab.router().disconnect(now, tail, core::CloseReason::kSilent);
  for (const int limit : {1, 2, 3, 9, 10}) {
    std::vector<json::object> missing;
    std::string after;
    do {
      const auto answer =
          ask(lab, fmt::format(R"({{"ask":"routers","limit":{},"after":"{}"}})", limit, after));
      for (const auto& item : answer.at("items").as_array())
        if (item.at("kind") == "missing") missing.push_back(item.as_object());
      after = answer.contains("next") ? answer.at("next").as_string().c_str() : "";
    } while (!after.empty());
    // "head" is silent, and still reported as a link.
    ASSERT_EQ(missing.size(), 2U) << limit;
    EXPECT_EQ(missing[0].at("name"), "tail");
    EXPECT_TRUE(missing[1].at("name").is_null());
    EXPECT_EQ(missing[1].at("address").at("name"), "Tims(3/15)");
    EXPECT_EQ(missing[1].at("behind").at("name"), "Tims(3/14)");
    EXPECT_EQ(missing[1].at("via"), "tail");
    EXPECT_EQ(missing[1].at("state"), "down");
    EXPECT_EQ(missing[1].at("since_s").to_number<double>(), 10);
  }
}

TEST(Reports, PagesJoinToTheWhole) {
  const LinkedFixture lab;
  for (const int limit : {1, 2, 3}) {
    EXPECT_EQ(items(lab, "links", limit).size(), 7U) << limit;
    EXPECT_EQ(items(lab, "routers", limit).size(), 8U) << limit;
  }
}

}  // namespace reports_test
}  // namespace tims::io

#include "router/io/reports.h"

#include <array>
#include <chrono>
#include <fstream>
#include <iterator>
#include <map>

#include <boost/json/parse.hpp>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "router/io/linked_fixture.h"

namespace tims::io {
namespace reports_test {

namespace json = boost::json;
using test::LinkedFixture;

json::object ask(const LinkedFixture& lab, const std::string& question) {
  return json::parse(answer_admin(question, lab, LinkedFixture::clocks())).as_object();
}
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

// What a report's JSON has, in order: "name, address, listen {unix, tcp}".
template <typename Report>
std::string fields_of();

template <typename Report, typename Value>
std::string field_text(std::string_view name) {
  if constexpr (std::is_same_v<Value, AddressView>)
    return std::string(name);  // the same everywhere
  else if constexpr (Described<Value>)
    return name.empty() ? fields_of<Value>() : fmt::format("{} {{{}}}", name, fields_of<Value>());
  else if constexpr (DescribedOptional<Value>)
    return field_text<Report, typename Value::value_type>(name);
  else
    return std::string(name);
}

template <typename Report>
std::string fields_of() {
  std::string text;
  for_each_field<Report>([&]<typename Get>(const Field<Get>& field) {
    const std::string one = field_text<Report, FieldValue<Report, Get>>(field.name);
    if (!one.empty()) text.append(text.empty() ? "" : ", ").append(one);
  });
  return text;
}

// In lines of the document's width.
template <typename Report>
std::string fields_line(std::string_view what) {
  constexpr std::size_t kWidth = 110;
  std::string text;
  std::string line = fmt::format("    {}:", what);
  for (std::string rest = fields_of<Report>(); !rest.empty();) {
    const std::string word = rest.substr(0, rest.find(' '));
    rest.erase(0, std::min(rest.size(), word.size() + 1));
    if (line.size() + 1 + word.size() > kWidth) {
      text += line + "\n";
      line = "       ";
    }
    line += " " + word;
  }
  return text + line + "\n";
}

// The field lists in the document must equal those generated from the reports.
TEST(Reports, TheDocumentHasEveryField) {
  const std::string lists =
      fields_line<AddressView>("an address") + fields_line<StatusView>("tims/status/1") +
      fields_line<core::ClientReport>("tims/client/1") +
      fields_line<MailboxView>("tims/route/1, tims/mailbox/1") +
      fields_line<MailboxFill>("tims/mailbox/1 of a local one") +
      fields_line<SelfView>("tims/router_list/1, the router itself") +
      fields_line<RouterView>("tims/router_list/1, a neighbour") +
      fields_line<MissingView>("tims/router_list/1, a missing one") +
      fields_line<LinkView>("tims/link/1") + fields_line<PathView>("paths of tims/link/1") +
      fields_line<DdsReport>("dds of tims/fleet/1") +
      fields_line<AnnouncementView>("tims/fleet/1") +
      fields_line<core::CountReport>("tims/stats/1") +
      fields_line<shm::Counters>("mailboxes of tims/stats/1") +
      fields_line<EventView>("tims/event/1");
  std::ifstream file(TIMS_ADMIN_FILE);
  const std::string document(std::istreambuf_iterator<char>(file), {});
  EXPECT_NE(document.find("\n\n" + lists + "\n"), std::string::npos)
      << "router/io/ADMIN.md, under \"Fields\":\n\n"
      << lists;
}

TEST(Reports, EveryStateCanBeTold) {
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

TEST(Reports, ALinkThatIsUpTellsOfItsSession) {
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

TEST(Reports, ALinkThatWasNeverUpTellsOfItsAttempts) {
  const LinkedFixture lab;
  const auto links = items(lab, "links");
  const json::object& refused = links.at(LinkedFixture::to_refuser);
  EXPECT_EQ(refused.at("refusal"), "Tims(0/3) refuser accepts system 9, not 3");
  for (const char* field : {"peer", "epoch", "address", "heard_s", "rtt_s", "clock"})
    EXPECT_TRUE(refused.at(field).is_null()) << field;
  EXPECT_EQ(refused.at("packets_in"), 0);
  EXPECT_TRUE(links.at(LinkedFixture::to_unknown).at("peer_address").is_null());
}

TEST(Reports, ASilentLinkRemembersWhoItWas) {
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

TEST(Reports, RoutersThatWentWithTheirLinkAreToldAfterTheOthers) {
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

using namespace std::chrono_literals;

constexpr Time kStart{};

struct AnsweringSink : core::Port, core::RouterHooks {
  core::Outcome deliver(Time, const core::Receiver&, const core::Message&) override {
    return answer;
  }
  void reply(Time, const core::Receiver&, const Header&) override {}
  void close(const core::Receiver&, core::CloseReason) override {}
  void admin(Time, core::ClientId, const core::Message&) override {}
  void traced(core::ClientId, core::ClientId, const core::Message&) override {}
  void event(const core::Event&) override {}
  core::Outcome answer = core::Outcome::kDelivered;
};

struct Source : AdminSource {
  Source() {
    for (const auto kind : core::values<core::PortKind, core::kPortKindCount>())
      router_.attach(kind, sink);
  }
  const core::Router& router() const override { return router_; }
  ProcessReport process(Time now) const override {
    return {.name = name,
            .version = "0.1.0",
            .uptime = now - kStart,
            .rss_bytes = 7'340'032,
            .longest_turn = 1250us};
  }
  const config::Config& config() const override { return config_; }
  const config::Origins& origins() const override { return origins_; }
  std::optional<MailboxFill> fill(std::uint32_t) const override { return {}; }
  shm::Counters mailbox_counts() const override { return {.received = 50, .replaced = 4}; }
  std::uint64_t queued_bytes(core::PortKind port, std::uint32_t token) const override {
    return port == core::PortKind::kTcp ? 100 + token : 0;
  }

  core::ClientId connect(core::PortKind port, std::uint32_t token = 0) {
    return router_.connect(kStart, {.port = port, .token = token});
  }
  core::Outcome send(core::ClientId from, Header header) {
    std::array<std::byte, 20> bytes{};
    header.length = bytes.size();
    core::Message message{header, bytes};
    return router_.on_message(kStart, from, message);
  }

  std::string name = "robot7";
  AnsweringSink sink;
  core::Router router_{{.address = Address(0x03000100)}, {}, sink};
  config::Config config_;
  config::Origins origins_;
};

// Lines that begin so.
std::string lines(const std::string& text, std::string_view beginning) {
  std::string found;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at) + 1;
    const std::string_view line = std::string_view(text).substr(at, end - at);
    if (line.starts_with(beginning)) found += line;
    at = end;
  }
  return found;
}

constexpr std::string_view kGolden =
    R"golden(# HELP tims_router_messages_total Messages by the port they came through, priority class (0 to 7) and outcome.
# TYPE tims_router_messages_total counter
tims_router_messages_total{port="tcp",class="1",outcome="delivered"} 1
tims_router_messages_total{port="tcp",class="7",outcome="no_route"} 1
tims_router_messages_total{port="websocket",class="1",outcome="queue_full"} 1
# HELP tims_router_message_bytes_total Bytes of these messages, headers included.
# TYPE tims_router_message_bytes_total counter
tims_router_message_bytes_total{port="tcp",class="1",outcome="delivered"} 20
tims_router_message_bytes_total{port="tcp",class="7",outcome="no_route"} 20
tims_router_message_bytes_total{port="websocket",class="1",outcome="queue_full"} 20
# HELP tims_router_drops_total Messages that were lost, by reason.
# TYPE tims_router_drops_total counter
tims_router_drops_total{reason="no_route"} 1
tims_router_drops_total{reason="mailbox_full"} 0
tims_router_drops_total{reason="mailbox_replaced"} 0
tims_router_drops_total{reason="too_big"} 0
tims_router_drops_total{reason="queue_full"} 1
tims_router_drops_total{reason="queue_replaced"} 0
tims_router_drops_total{reason="client_gone"} 0
tims_router_drops_total{reason="owner_gone"} 0
tims_router_drops_total{reason="forged_source"} 0
tims_router_drops_total{reason="bad_length"} 0
tims_router_drops_total{reason="incomplete"} 0
tims_router_drops_total{reason="malformed_command"} 0
tims_router_drops_total{reason="unknown_command"} 0
tims_router_drops_total{reason="hop_limit"} 0
tims_router_drops_total{reason="would_return"} 0
tims_router_drops_total{reason="link_reset"} 0
tims_router_drops_total{reason="expired"} 0
# HELP tims_router_events_total Events of clients and mailboxes, by kind.
# TYPE tims_router_events_total counter
tims_router_events_total{event="client_came"} 3
tims_router_events_total{event="client_went"} 0
tims_router_events_total{event="client_refused"} 0
tims_router_events_total{event="registered"} 1
tims_router_events_total{event="withdrawn"} 0
tims_router_events_total{event="address_refused"} 0
tims_router_events_total{event="mailbox_limit"} 0
tims_router_events_total{event="delete_refused"} 0
tims_router_events_total{event="watchdog_closed"} 0
tims_router_events_total{event="protocol_error"} 0
tims_router_events_total{event="link_up"} 0
tims_router_events_total{event="link_down"} 0
tims_router_events_total{event="link_refused"} 0
tims_router_events_total{event="link_path"} 0
tims_router_events_total{event="uplink_changed"} 0
tims_router_events_total{event="duplicate_address"} 0
tims_router_events_total{event="duplicate_router"} 0
tims_router_events_total{event="loop"} 0
tims_router_events_total{event="forged_source_tolerated"} 3
tims_router_events_total{event="not_available"} 1
tims_router_events_total{event="lifesign"} 0
# HELP tims_mailbox_messages_total Messages to mailboxes in shared memory, from all senders, by outcome.
# TYPE tims_mailbox_messages_total counter
tims_mailbox_messages_total{outcome="received"} 50
tims_mailbox_messages_total{outcome="replaced"} 4
tims_mailbox_messages_total{outcome="refused"} 0
tims_mailbox_messages_total{outcome="too_big"} 0
tims_mailbox_messages_total{outcome="reclaimed"} 0
# HELP tims_router_clients Clients that are connected, by port.
# TYPE tims_router_clients gauge
tims_router_clients{port="local"} 0
tims_router_clients{port="tcp"} 2
tims_router_clients{port="websocket"} 1
tims_router_clients{port="link"} 0
# HELP tims_router_queued_bytes Bytes queued in the router for clients that read slowly, by port.
# TYPE tims_router_queued_bytes gauge
tims_router_queued_bytes{port="local"} 0
tims_router_queued_bytes{port="tcp"} 203
tims_router_queued_bytes{port="websocket"} 0
tims_router_queued_bytes{port="link"} 0
# HELP tims_router_mailboxes Mailboxes that are registered.
# TYPE tims_router_mailboxes gauge
tims_router_mailboxes 1
# HELP tims_router_table_bytes Memory of the table of mailboxes.
# TYPE tims_router_table_bytes gauge
tims_router_table_bytes 3168
# HELP tims_router_uptime_seconds Time since the router was started.
# TYPE tims_router_uptime_seconds gauge
tims_router_uptime_seconds 62.5
# HELP tims_router_longest_turn_seconds Longest turn of the event loop: so long have others had to wait.
# TYPE tims_router_longest_turn_seconds gauge
tims_router_longest_turn_seconds 0.00125
# HELP process_resident_memory_bytes Memory of the router's process.
# TYPE process_resident_memory_bytes gauge
process_resident_memory_bytes 7340032
# HELP tims_router_info Always 1; labels identify this router.
# TYPE tims_router_info gauge
tims_router_info{name="robot7",address="Tims(3/1)",version="0.1.0"} 1
)golden";

TEST(MetricsText, Golden) {
  Source source;
  const Address ladar(0x03140000);
  const auto owner = source.connect(core::PortKind::kTcp, 1);
  const auto sender = source.connect(core::PortKind::kTcp, 2);
  const auto browser = source.connect(core::PortKind::kWebSocket);
  source.router_.register_mailbox(kStart, owner, ladar);
  source.send(sender, {.type = 1, .dest = ladar, .src = Address(9)});
  source.send(sender, {.type = 1, .priority = 255, .dest = Address(8), .src = Address(9)});
  source.sink.answer = core::Outcome::kQueueFull;
  source.send(browser, {.type = 1, .dest = ladar, .src = Address(9)});
  EXPECT_EQ(metrics_text(source, kStart + 62500ms), kGolden);
}

TEST(MetricsText, ANameWithQuotesStaysInsideItsQuotes) {
  Source source;
  source.name = "a\"b\\c\nd";
  EXPECT_EQ(
      lines(metrics_text(source, kStart), "tims_router_info"),
      "tims_router_info{name=\"a\\\"b\\\\c\\nd\",address=\"Tims(3/1)\",version=\"0.1.0\"} 1\n");
}

TEST(MetricsText, AnOlderMessageThatHadToGoIsADrop) {
  Source source;
  const auto owner = source.connect(core::PortKind::kLocal);
  source.router_.register_mailbox(kStart, owner, Address(5));
  source.sink.answer = core::Outcome::kMailboxReplaced;
  source.send(source.connect(core::PortKind::kTcp), {.dest = Address(5), .src = Address(6)});
  const std::string text = metrics_text(source, kStart);
  EXPECT_EQ(lines(text, "tims_router_drops_total{reason=\"mailbox_replaced\"}"),
            "tims_router_drops_total{reason=\"mailbox_replaced\"} 1\n");
}

// 3 ports and the router, 8 classes, every outcome: what a scrape may cost at most.
TEST(MetricsText, HowLongItCanGet) {
  Source source;
  for (std::uint32_t i = 0; i < 500; ++i) {
    const auto client = source.connect(core::PortKind::kTcp, i);
    source.router_.register_mailbox(kStart, client, Address(0x10000 + i));
    for (int priority = 0; priority < 256; priority += 16)
      source.send(client, {.priority = static_cast<std::uint8_t>(priority), .dest = Address(1)});
  }
  EXPECT_LT(metrics_text(source, kStart).size(), 8000U);
}

}  // namespace reports_test

}  // namespace tims::io

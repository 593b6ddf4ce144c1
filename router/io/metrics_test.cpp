#include "router/io/metrics.h"

#include <array>
#include <chrono>

#include <gtest/gtest.h>

namespace tims::io {
namespace metrics_test {

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
tims_router_drops_total{reason="no_lease"} 0
tims_router_drops_total{reason="no_right"} 0
tims_router_drops_total{reason="denied"} 0
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
tims_router_events_total{event="memory_closed"} 0
tims_router_events_total{event="link_up"} 0
tims_router_events_total{event="link_down"} 0
tims_router_events_total{event="link_refused"} 0
tims_router_events_total{event="link_path"} 0
tims_router_events_total{event="link_renamed"} 0
tims_router_events_total{event="uplink_changed"} 0
tims_router_events_total{event="duplicate_address"} 0
tims_router_events_total{event="duplicate_router"} 0
tims_router_events_total{event="loop"} 0
tims_router_events_total{event="lease_taken"} 0
tims_router_events_total{event="lease_ended"} 0
tims_router_events_total{event="driving_refused"} 0
tims_router_events_total{event="denied"} 0
tims_router_events_total{event="observed"} 0
tims_router_events_total{event="policy_changed"} 0
tims_router_events_total{event="router_changed"} 0
tims_router_events_total{event="forged_source_tolerated"} 3
tims_router_events_total{event="not_available"} 1
tims_router_events_total{event="lifesign"} 0
# HELP tims_router_rule_messages_total Messages that a rule of the policy has matched, by what became of them.
# TYPE tims_router_rule_messages_total counter
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
# HELP tims_http_refusals_total Requests from browsers that were refused, by the rule they violated.
# TYPE tims_http_refusals_total counter
tims_http_refusals_total{rule="host"} 0
tims_http_refusals_total{rule="origin"} 0
tims_http_refusals_total{rule="cross_site"} 0
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

}  // namespace metrics_test
}  // namespace tims::io

// A router with a few clients and its surroundings, for tests and fuzzers of the admin protocol.
#pragma once

#include <deque>
#include <vector>

#include <boost/json/parse.hpp>

#include "router/core/router.h"
#include "router/io/admin_actions.h"
#include "router/io/admin_answers.h"
#include "router/io/admin_service.h"

namespace tims::io::test {

// Accepts everything and stores the questions.
class QuietHooks final : public core::Port, public core::RouterHooks {
 public:
  core::Outcome deliver(Time, const core::Receiver&, const core::Message&) override {
    return core::Outcome::kDelivered;
  }
  void reply(Time, const core::Receiver&, const Header&) override {}
  void close(const core::Receiver&, core::CloseReason) override {}
  void keep_newest(const core::Receiver& client) override {
    streams_of = client.token;
    counters.add({.flags = flag::kStream, .type = type::kData, .src = Address(0x03140000)});
  }
  [[nodiscard]] const core::StreamCounters* streams(std::uint32_t token) const override {
    return token == streams_of ? &counters : nullptr;
  }
  void admin(Time, core::ClientId, const core::Message&) override {}
  void traced(core::ClientId, core::ClientId, const core::Message&) override {}
  void event(const core::Event&) override {}

  std::uint32_t streams_of = 0;
  core::StreamCounters counters;
};

// The router Tims(3/1) at second 100; clients "laser" (local, Ladar(3/0)) and 127.0.0.1:50000
// (TCP, Pilot(3/0)).
class AdminFixture : public AdminSource {
 public:
  explicit AdminFixture(core::Role role = core::Role::kSystem)
      : router_({.address = Address(0x03000100), .role = role}, core::HashSeed{}, hooks_) {
    for (const auto kind : core::values<core::PortKind, core::kPortKindCount>())
      router_.attach(kind, hooks_);
    config_.router.name = "lab";
    laser_ = router_.connect(at(10), {.port = core::PortKind::kLocal,
                                      .token = 1,
                                      .pid = 811,
                                      .name = std::string_view("laser")});
    pilot_ = router_.connect(at(20), {.port = core::PortKind::kTcp,
                                      .token = 2,
                                      .endpoint = std::string_view("127.0.0.1:50000")});
    router_.register_mailbox(at(30), laser_, Address(0x03140000), 7);
    router_.register_mailbox(at(40), pilot_, Address(0x03180000));
    core::NewestRule rule{.status = true, .length_max = 1024};
    rule.classes.set();
    newest_.set_rule(rule);
    router_.keep_newest(newest_);
  }

  static Time at(int second) { return Time(std::chrono::seconds(second)); }
  static Clocks clocks(int second = 100) {
    return {at(second), WallTime(std::chrono::seconds(1'800'000'000 + second))};
  }

  [[nodiscard]] const core::Router& router() const override { return router_; }
  [[nodiscard]] core::Router& router() { return router_; }
  [[nodiscard]] core::ClientId laser() const { return laser_; }
  [[nodiscard]] core::ClientId pilot() const { return pilot_; }

  void configure(const std::vector<std::string>& settings) {
    const config::Loaded loaded = config::load({.files = {}, .settings = settings, .host = {}});
    config_ = loaded.config;
    origins_ = loaded.origins;
  }

  core::LeaseResult change_lease(Time now, core::ClientId from, core::LeaseVerb verb,
                                 const core::DrivingLease& holder) override {
    return router_.change_lease(now, from, verb, holder);
  }
  void keep_up_to(std::uint32_t length) {
    core::NewestRule rule{.length_max = length};
    rule.classes.set();
    newest_.set_rule(rule);
  }
  // A message of the laser passes the router.
  void pass_sample(int second, std::span<std::byte> bytes, std::int8_t type = type::kData) {
    core::Message message{.header = {.flags = flag::kNativeOrder | flag::kStream,
                                     .type = type,
                                     .dest = Address(0x03180000),
                                     .src = Address(0x03140000),
                                     .length = static_cast<std::uint32_t>(bytes.size())},
                          .bytes = bytes};
    router_.on_message(at(second), laser_, message);
  }

  [[nodiscard]] ProcessReport process(Time now) const override {
    return {.name = "lab",
            .version = "0.1.0",
            .pid = 42,
            .epoch = 0xabc,
            .uptime = now.time_since_epoch(),
            .rss_bytes = 1 << 20,
            .longest_turn = std::chrono::milliseconds(2),
            .unix_path = "/run/tims/router.sock"};
  }
  [[nodiscard]] const config::Config& config() const override { return config_; }
  [[nodiscard]] const config::Origins& origins() const override { return origins_; }
  [[nodiscard]] std::optional<MailboxFill> fill(std::uint32_t handle) const override {
    if (handle != 7) return std::nullopt;
    return MailboxFill{.slots = 16, .message_max = 1476, .waiting = 3, .counts = {.received = 900}};
  }
  [[nodiscard]] shm::Counters mailbox_counts() const override {
    return {.received = 1000, .replaced = 4, .refused = 3, .too_big = 2, .reclaimed = 1};
  }
  [[nodiscard]] std::uint64_t queued_bytes(core::PortKind port, std::uint32_t) const override {
    return port == core::PortKind::kTcp ? tcp_queued_bytes : 0;
  }
  std::uint64_t tcp_queued_bytes = 512;

 private:
  QuietHooks hooks_;
  core::NewestValues newest_{256 << 10, core::HashSeed{}};
  core::Router router_;
  config::Config config_;
  config::Origins origins_{{"router.name", {.kind = config::Origin::Kind::kSet, .number = 1}}};
  core::ClientId laser_{};
  core::ClientId pilot_{};
};

// The answer to a question that changes nothing.
inline boost::json::object ask(const AdminFixture& lab, std::string_view question) {
  return boost::json::parse(answer_admin(question, lab, AdminFixture::clocks())).as_object();
}
inline std::string_view text(const boost::json::value& value) { return value.as_string(); }
inline std::string_view error_code(const boost::json::object& answer) {
  return answer.at("error").at("code").as_string();
}

}  // namespace tims::io::test

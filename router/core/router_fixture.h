// A router that records its decisions, for tests.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "router/core/router.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::core::test {

using Bytes = std::vector<std::byte>;
namespace command = wire::router_command;

inline Bytes bytes_of(std::string_view text) {
  Bytes bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

// An encoded message, in the byte order given by its flags.
inline Bytes encoded(Header header, const Bytes& body = {}) {
  header.length = static_cast<std::uint32_t>(kHeaderSize + body.size());
  Bytes bytes(header.length);
  const bool little = (header.flags & flag::kHeaderLittleEndian) != 0;
  wire::encode_header(header, std::span(bytes).first<kHeaderSize>(),
                      little ? std::endian::little : std::endian::big);
  std::ranges::copy(body, bytes.begin() + kHeaderSize);
  return bytes;
}

class RecordingSink final : public Port, public RouterHooks {
 public:
  struct Delivery {
    Receiver to;
    Header header;
    Bytes bytes;
  };
  struct Reply {
    Receiver to;
    Header header;
  };
  struct Close {
    ClientId client;
    CloseReason reason;
  };

  Outcome deliver(Time, const Receiver& to, const Message& message) override {
    delivered.push_back({to, message.header, {message.bytes.begin(), message.bytes.end()}});
    return outcome;
  }
  void reply(Time, const Receiver& to, const Header& header) override {
    replies.push_back({to, header});
  }
  void close(const Receiver& client, CloseReason reason) override {
    closed.emplace_back(client.client, reason);
  }
  void admin(Time, ClientId from, const Message& request) override {
    questions.emplace_back(from, request.header.src);
  }
  void deny_admin(ClientId, const Message&, std::string_view rule) override {
    denied.emplace_back(rule);
  }
  policy::Right right_of(const Message&) override { return right; }
  bool writes_rules(const ClientInfo& client) override { return client.uid == writer; }
  void trace_denied(ClientId, const Message&, std::string_view) override { ++traces_denied; }
  void traced(ClientId from, ClientId to, const Message&) override {
    traces.emplace_back(from, to);
  }
  void event(const Event& event) override { events.push_back(event); }
  void moved(Address address) override { moved_addresses.push_back(address); }

  Outcome outcome = Outcome::kDelivered;       // returned for every delivery
  std::uint32_t writer = 77;                   // the user that writes rules
  policy::Right right = policy::Right::kLook;  // that questions need
  std::vector<Delivery> delivered;
  std::vector<Reply> replies;
  std::vector<Close> closed;
  std::vector<std::pair<ClientId, Address>> questions;
  std::vector<std::string> denied;  // questions
  std::vector<std::pair<ClientId, ClientId>> traces;
  int traces_denied = 0;
  std::vector<Event> events;
  std::vector<Address> moved_addresses;
};

// Uses one sink for all ports of the router.
inline void attach_all(Router& router, Port& sink) {
  for (const PortKind kind : values<PortKind, kPortKindCount>()) router.attach(kind, sink);
}

class RouterTest : public testing::Test {
 protected:
  RouterTest() { attach_all(router_, sink_); }

  static Time at(int seconds) { return Time(std::chrono::seconds(seconds)); }

  ClientId connect(PortKind port = PortKind::kTcp, std::string_view name = {}) {
    return router_.connect(now_, {.port = port, .token = ++token_, .name = name});
  }
  ClientId link(LinkKind kind, std::uint8_t system, std::string_view name) {
    return router_.connect(now_,
                           {.port = PortKind::kLink,
                            .token = ++token_,
                            .name = name,
                            .link = {.name = name,
                                     .kind = kind,
                                     .role = Role::kSystem,
                                     .system = system,
                                     .router = Address::of({.system = system, .instance = 1})}});
  }
  Outcome send_bytes(ClientId from, const Bytes& bytes) {
    sent_ = bytes;
    Message message{wire::decode_header(std::span(bytes).first<kHeaderSize>()), sent_};
    return router_.on_message(now_, from, message);
  }
  Outcome send(ClientId from, const Header& header, const Bytes& body = {}) {
    return send_bytes(from, encoded(header, body));
  }
  // A command with dest = src = 0 and a mailbox in its body, big-endian.
  Outcome send_command(ClientId from, std::int8_t type, std::uint32_t mailbox,
                       std::uint8_t priority = 0, std::uint8_t seq_nr = 0) {
    Bytes body;
    for (int shift = 24; shift >= 0; shift -= 8) body.push_back(std::byte(mailbox >> shift & 0xFF));
    return send(from, {.flags = 0, .type = type, .priority = priority, .seq_nr = seq_nr}, body);
  }
  [[nodiscard]] std::uint64_t count(PortKind port, Outcome outcome) const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < kClasses; ++i) {
      sum += router_.messages().of(port, i, outcome).messages;
    }
    return sum;
  }
  [[nodiscard]] std::uint64_t count(EventKind kind) const {
    return router_.event_counts().of(kind);
  }
  // Whom a message of this client is handed to.
  [[nodiscard]] ClientId hop_of(ClientId from, Address to) const {
    const NextHop hop = router_.routes().next_hop(router_.client(from), to);
    return hop.to == nullptr ? kNoClient : hop.to->id;
  }
  [[nodiscard]] ClientId owner(std::uint32_t address) const {
    const Table::Entry* entry = router_.find(Address(address));
    return entry == nullptr ? kNoClient : entry->owner;
  }

  static constexpr Address kOwn{0x00000100};  // Tims(0/1)
  RecordingSink sink_;
  Router router_{
      {.address = kOwn, .clients_max = 100, .mailboxes_per_client_max = 10}, {1, 2}, sink_};
  Time now_ = at(100);
  std::uint32_t token_ = 0;
  Bytes sent_;  // the last message, as rewritten by the router
};

}  // namespace tims::core::test

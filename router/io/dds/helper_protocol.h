// What a router and its DDS helper say to each other: one record a message of a SEQPACKET socket.
// Neither side believes the other: what cannot be decoded ends the conversation. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "router/io/dds/dds_engine.h"
#include "router/link/datagram.h"
#include "router/link/transport.h"

namespace tims::io::helper {

// The largest record: a burst or batch with its address.
inline constexpr std::size_t kRecordMax = 68'000;

// --- from the router

struct Start {
  DdsSettings settings{};
  link::Announcement self{};
};
struct Restart {
  link::Announcement self{};
};
struct Connect {
  link::NetAddress to{};
};
struct Stop {};

// --- from the helper

// The answer to Start, once: empty if the settings can work.
struct Started {
  std::string error{};
};
// After every change, and every second for the counters.
struct Report {
  DdsEngine::State state = DdsEngine::State::kOff;
  link::NetAddress address{};
  std::vector<link::NetAddress> host{};  // as DdsEngine::host()
  std::string last_error{};
  DdsEngine::Counters counters{};
};
// Datagrams of one router, as link::Batch.
struct Arrived {
  link::NetAddress from{};
  std::span<std::byte> batch{};
};
struct Announced {
  link::Announcement announcement{};
};
struct Gone {
  link::NetAddress dds{};
};

// Burst: to be sent.
using Record = std::variant<Start, Restart, Connect, link::Burst, Stop, Started, Report, Arrived,
                            Announced, Gone>;

// `to` has kRecordMax bytes. Returns the record's size; 0 when it does not fit.
std::size_t encode(const Record& record, std::span<std::byte> to);
// Empty for bytes that are no record. Views in the result are of `bytes`.
std::optional<Record> decode(std::span<std::byte> bytes);

}  // namespace tims::io::helper

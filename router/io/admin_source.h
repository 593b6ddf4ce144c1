// What answers are made of: the core's reports, and what only the process and its ports know.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "router/config/config.h"
#include "router/config/load.h"
#include "router/core/router.h"
#include "router/link/fault_injection.h"
#include "router/link/links.h"
#include "tims/time.h"

namespace tims::io {

// The socket under all links.
struct UdpReport {
  std::uint32_t asked_buffer_bytes = 0;  // of the system, in each direction
  std::uint32_t receive_buffer_bytes = 0;
  std::uint32_t send_buffer_bytes = 0;
  std::uint64_t dropped_by_kernel = 0;  // datagrams for which the buffer had no room
};

// The engine under all DDS paths.
struct DdsReport {
  std::string state{};    // "up", "starting"
  std::string trouble{};  // what it last complained about
  std::string address{};
  std::uint64_t samples_in = 0;
  std::uint64_t samples_out = 0;
  std::uint64_t datagrams_in = 0;
  std::uint64_t datagrams_out = 0;
  std::uint64_t strange = 0;    // samples that are none of ours
  std::uint64_t refused = 0;    // datagrams for which there was no room, or nobody
  std::uint64_t unmatched = 0;  // datagrams whose receiver did not appear
  std::uint64_t waiting_bytes = 0;
};

struct ProcessReport {
  std::string name;     // router.name
  std::string version;  // of the program
  std::uint32_t pid = 0;
  std::uint64_t epoch = 0;  // drawn at start
  Duration uptime{};
  std::uint64_t rss_bytes = 0;
  Duration longest_turn{};  // of the event loop
  // Where it listens; empty: it does not.
  std::string unix_path{};
  std::string tcp{};
  std::string http{};
  std::string udp{};
  std::optional<UdpReport> udp_socket{};
};

// What became of messages to mailboxes in shared memory, whoever sent them.
struct MailboxCounts {
  std::uint64_t received = 0;
  std::uint64_t replaced = 0;
  std::uint64_t refused = 0;
  std::uint64_t too_big = 0;
  std::uint64_t reclaimed = 0;

  MailboxCounts& operator+=(const MailboxCounts& more) {
    received += more.received;
    replaced += more.replaced;
    refused += more.refused;
    too_big += more.too_big;
    reclaimed += more.reclaimed;
    return *this;
  }
};

// What is to be seen of a mailbox in shared memory.
struct MailboxFill {
  std::uint32_t slots = 0;
  std::uint32_t message_max = 0;  // bytes, header included
  std::uint64_t waiting = 0;
  MailboxCounts counts{};
  bool asleep = false;
};

class AdminSource {
 public:
  virtual ~AdminSource() = default;

  [[nodiscard]] virtual const core::Router& router() const = 0;
  [[nodiscard]] virtual ProcessReport process(Time now) const = 0;
  [[nodiscard]] virtual const config::Config& config() const = 0;
  [[nodiscard]] virtual const config::Origins& origins() const = 0;
  // Null when there are none to be told of.
  [[nodiscard]] virtual const link::Links* links() const { return nullptr; }
  // Nothing when this router is in no fleet.
  [[nodiscard]] virtual std::optional<DdsReport> dds() const { return std::nullopt; }
  // Does what a question asks for; false: there is no such link.
  virtual bool act_on_link(std::string_view, link::Links::Action) const { return false; }
  virtual bool inject_faults(std::string_view, const link::Faults&) const { return false; }
  virtual void set_static_routes(const std::vector<core::StaticRoute>&) const {}
  // `handle` of a local mailbox (core::MailboxReport); nothing when it cannot be told.
  [[nodiscard]] virtual std::optional<MailboxFill> fill(std::uint32_t handle) const = 0;
  // Of all of them, those that are gone as well.
  [[nodiscard]] virtual MailboxCounts mailbox_counts() const = 0;
  [[nodiscard]] virtual std::uint64_t queued_bytes(core::PortKind port,
                                                   std::uint32_t token) const = 0;

 protected:
  AdminSource() = default;
  AdminSource(const AdminSource&) = default;
  AdminSource& operator=(const AdminSource&) = default;
};

}  // namespace tims::io

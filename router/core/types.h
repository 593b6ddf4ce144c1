// Types used throughout the core: closed lists, which do not allocate; clients, the kinds of ports
// they attach to, and routers; a message in transit, and the eight classes that messages have by
// priority.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "tims/address.h"
#include "tims/message.h"
#include "tims/text.h"
#include "tims/time.h"

namespace tims::core {

// --- closed lists

// An enum with, for each value, one name for JSON and metrics and one sentence for users. A list
// that misses a value, or has two in the wrong order, does not compile.
template <typename Enum>
struct Label {
  Enum value;
  std::string_view name;      // snake_case
  std::string_view sentence;  // without a full stop
};

// True when `labels` has every value from 0 to `last`, in order.
template <typename Enum, std::size_t size>
constexpr bool complete(const std::array<Label<Enum>, size>& labels, Enum last) {
  if (size != static_cast<std::size_t>(last) + 1) return false;
  for (std::size_t i = 0; i < size; ++i) {
    if (static_cast<std::size_t>(labels[i].value) != i || labels[i].name.empty()) return false;
  }
  return true;
}

// Label of a value in a complete list.
template <typename Enum, std::size_t size>
constexpr const Label<Enum>& label(const std::array<Label<Enum>, size>& labels, Enum value) {
  return labels[static_cast<std::size_t>(value)];
}

// The names in a list.
template <typename Enum, std::size_t size>
constexpr std::array<std::string_view, size> names(const std::array<Label<Enum>, size>& labels) {
  std::array<std::string_view, size> all{};
  for (std::size_t i = 0; i < size; ++i) all[i] = labels[i].name;
  return all;
}

// All values of an enum that has `count` values.
template <typename Enum, std::size_t count>
constexpr std::array<Enum, count> values() {
  std::array<Enum, count> all{};
  for (std::size_t i = 0; i < count; ++i) all[i] = static_cast<Enum>(i);
  return all;
}

// Base of classes that others implement. Not copyable through this base.
class Interface {
 public:
  virtual ~Interface() = default;

 protected:
  Interface() = default;
  Interface(const Interface&) = default;
  Interface& operator=(const Interface&) = default;
};

// --- clients, routers and links

// Identifies a client while it is connected. Numbers are assigned in sequence: a number is not
// reused before four billion others.
struct ClientId {
  std::uint32_t value = 0;

  explicit constexpr operator bool() const { return value != 0; }
  auto operator<=>(const ClientId&) const = default;
};
inline constexpr ClientId kNoClient{};

enum class PortKind : std::uint8_t {
  kLocal,      // Unix socket and shared memory
  kTcp,        // original RACK programs and remote clients
  kWebSocket,  // browsers
  kRouter,     // the router itself: its admin answers
  kLink,       // another router
};
inline constexpr std::size_t kPortKindCount = 5;
// Not inline: tables that contain texts are placed in read-only memory only when they are
// constants of each file that uses them.
constexpr std::array kPortKinds{
    Label<PortKind>{PortKind::kLocal, "local", "a program on this host"},
    Label<PortKind>{PortKind::kTcp, "tcp", "a program connected over TCP"},
    Label<PortKind>{PortKind::kWebSocket, "websocket", "a browser"},
    Label<PortKind>{PortKind::kRouter, "router", "the router itself"},
    Label<PortKind>{PortKind::kLink, "link", "another router"},
};
static_assert(complete(kPortKinds, PortKind::kLink) && kPortKinds.size() == kPortKindCount);
std::string_view name(PortKind port);

inline constexpr std::size_t kClasses = 8;  // of messages, by priority

enum class Role : std::uint8_t { kSubsystem, kSystem, kTop };
constexpr std::array kRoles{
    Label<Role>{Role::kSubsystem, "subsystem", "the router of one host of a robot"},
    Label<Role>{Role::kSystem, "system", "the highest router of a robot"},
    Label<Role>{Role::kTop, "top", "the router above all robots"},
};
static_assert(complete(kRoles, Role::kTop));
std::string_view name(Role role);

// The role of the other router relative to this one.
enum class LinkKind : std::uint8_t { kSuper, kPeer, kSub };
constexpr std::array kLinkKinds{
    Label<LinkKind>{LinkKind::kSuper, "super", "the router above"},
    Label<LinkKind>{LinkKind::kPeer, "peer", "a router beside"},
    Label<LinkKind>{LinkKind::kSub, "sub", "a router below"},
};
static_assert(complete(kLinkKinds, LinkKind::kSub));
std::string_view name(LinkKind kind);

// Transports for the datagrams of a link.
enum class PathKind : std::uint8_t { kUdp, kDds, kTcp };
inline constexpr std::size_t kPathKindCount = 3;
constexpr std::array kPathKinds{
    Label<PathKind>{PathKind::kUdp, "udp", "from address to address"},
    Label<PathKind>{PathKind::kDds, "dds", "DDS"},
    Label<PathKind>{PathKind::kTcp, "tcp", "a connection to the upper router"},
};
static_assert(complete(kPathKinds, PathKind::kTcp) && kPathKinds.size() == kPathKindCount);
std::string_view name(PathKind kind);

// Whether sensor data are compressed on a link.
enum class Compression : std::uint8_t { kAuto, kOff, kLz4, kZstd };
constexpr std::array kCompressions{
    Label<Compression>{Compression::kAuto, "auto", "by the rate of the link"},
    Label<Compression>{Compression::kOff, "off", "never"},
    Label<Compression>{Compression::kLz4, "lz4", "with LZ4, which is fast"},
    Label<Compression>{Compression::kZstd, "zstd", "with zstd, which saves more"},
};
static_assert(complete(kCompressions, Compression::kZstd));
std::string_view name(Compression compression);

// The router that owns a mailbox, as announced by a link.
struct Origin {
  Address router{};
  std::uint32_t epoch = 0;  // the lower half of that router's epoch
  std::uint8_t hops = 0;    // links between that router and this one

  // True for the same instance of the router: same address and same epoch.
  [[nodiscard]] bool same_router(const Origin& other) const {
    return router == other.router && epoch == other.epoch;
  }
  bool operator==(const Origin&) const = default;
};

// A message or registration that has passed this many links is in a loop.
inline constexpr std::uint8_t kHopsMax = 16;

// --- messages

struct Message {
  Header header{};  // decoded
  // The whole message, header included. The router rewrites the header here when it forwards, so
  // no other process may write to this memory: messages in shared memory are copied out first.
  std::span<std::byte> bytes{};
  std::uint8_t hops = 0;  // number of links it has passed
  Duration waited{};      // time in the queue of the last link, when the message is traced
  // The body is compressed, and header.length counts it like that (router/link/packing.h). Only
  // between two links: what arrives anywhere else has been decompressed.
  bool packed = false;

  [[nodiscard]] std::span<const std::byte> body() const { return bytes.subspan(kHeaderSize); }
};

// Messages are counted and, on links, sent in eight classes by priority. The thresholds must be
// the same in the whole fleet.
struct PriorityClasses {
  // The lowest priority of each class above 0. Priorities in RACK: 0 for tools and the GUI; 1 for
  // components without a configured priority; steps of ten up to 50 on robots (each data task one
  // below its command task, so 19 belongs to 20); 100 and above only for stop commands.
  std::array<std::uint8_t, kClasses - 1> from{0, 1, 15, 25, 35, 45, 100};
  // Where texts for users go, with the address widths of the fleet.
  Address texts = text_sink();

  // Texts for users are least important, although original programs send them with the priority
  // of their data. By convention they have class 0 to themselves.
  [[nodiscard]] constexpr std::size_t of(const Header& header) const {
    return header.dest == texts ? 0 : of(header.priority);
  }
  [[nodiscard]] constexpr std::size_t of(std::uint8_t priority) const {
    std::size_t message_class = 0;
    for (const std::uint8_t first : from) message_class += priority >= first ? 1 : 0;
    return message_class;
  }
  // The priority with which a message waits for a slow client: texts yield to all other messages.
  [[nodiscard]] constexpr std::uint8_t waits_with(const Header& header) const {
    return header.dest == texts ? 0 : header.priority;
  }
  // The same thresholds in a fleet with these address widths.
  [[nodiscard]] constexpr PriorityClasses at(const AddressWidths& widths) const {
    return {from, text_sink(widths)};
  }
  [[nodiscard]] constexpr bool valid() const {
    return std::ranges::adjacent_find(from, std::ranges::greater_equal()) == from.end();
  }
  // "0/1/15/25/35/45/100"
  [[nodiscard]] std::string to_string() const {
    std::string text;
    for (const std::uint8_t first : from)
      text.append(text.empty() ? "" : "/").append(std::to_string(first));
    return text;
  }
  bool operator==(const PriorityClasses&) const = default;
};
inline constexpr PriorityClasses kConventionalClasses{};

}  // namespace tims::core

// The datagrams with which two routers find each other and begin, byte for byte (PROTOCOL.md draws
// them), and what a router says of itself in them and to its whole fleet.
//
// HELLO, RETRY, WELCOME and REFUSE begin with the word "TIMS", so that any version can tell any
// other what it speaks; RESET says that its token is not known here. What is carried once a link is
// up goes in DATA (frame.h).
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "router/core/types.h"
#include "router/link/transport.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::link {

// Integers in datagrams: little-endian, read and written with bounds. Neither end ever leaves its
// span: a reader that has run out says so once (ok()) and reads zeros.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] bool empty() const { return rest_.empty(); }
  [[nodiscard]] std::span<const std::byte> rest() const { return rest_; }

  template <std::integral T>
  T get() {
    std::uint64_t value = 0;
    const auto bytes = take(sizeof(T));
    for (std::size_t i = 0; i < bytes.size(); ++i)
      value |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
    return static_cast<T>(value);
  }
  template <std::integral... T>
  void get(T&... values) {
    ((values = get<T>()), ...);
  }

  std::span<const std::byte> take(std::size_t size) {
    if (rest_.size() < size) {
      ok_ = false;
      rest_ = {};
      return {};
    }
    const auto taken = rest_.first(size);
    rest_ = rest_.subspan(size);
    return taken;
  }

  std::string_view text(std::size_t size) {
    const auto bytes = take(size);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes as the text they are
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

 private:
  std::span<const std::byte> rest_;
  bool ok_ = true;
};

// The caller has seen to it that there is room (room()).
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::byte> to) : to_(to) {}

  [[nodiscard]] std::size_t size() const { return used_; }
  [[nodiscard]] std::size_t room() const { return to_.size() - used_; }
  [[nodiscard]] std::span<std::byte> written() const { return to_.first(used_); }

  template <typename... T>  // integers, and enumerations
  void put(T... values) {
    (put_one(values), ...);
  }
  void put_bytes(std::span<const std::byte> bytes) {
    if (!bytes.empty()) std::memcpy(to_.data() + used_, bytes.data(), bytes.size());
    used_ += bytes.size();
  }
  void put_text(std::string_view text) { put_bytes(std::as_bytes(std::span(text))); }
  // The next `size` bytes, for somebody else to fill.
  std::span<std::byte> reserve(std::size_t size) {
    used_ += size;
    return to_.subspan(used_ - size, size);
  }

 private:
  template <typename T>
  void put_one(T value) {
    static_assert(std::integral<T> || std::is_enum_v<T>);
    for (std::size_t i = 0; i < sizeof(T); ++i)
      to_[used_ + i] = static_cast<std::byte>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFF);
    used_ += sizeof(T);
  }

  std::span<std::byte> to_;
  std::size_t used_ = 0;
};

using core::LinkKind;
using core::Role;

// Who a router is. `epoch` is drawn at random when it starts.
struct Identity {
  std::uint64_t epoch = 0;
  Role role = Role::kSystem;
  std::uint8_t system = 0;
  std::uint8_t id = 0;
  core::Text<63> name{};
  AddressWidths widths{};
  std::uint32_t message_max = 0;  // bytes, header included
  core::PriorityClasses classes{};

  [[nodiscard]] Address address() const {
    return Address::of({.system = system, .instance = id}, widths);
  }
  bool operator==(const Identity&) const = default;
};

// Whether `who` is what a router like `below` looks for above it: the system router of its system,
// or a top-level one.
inline bool is_above(const Identity& who, const Identity& below) {
  if (below.role == Role::kSubsystem)
    return who.role == Role::kSystem && who.system == below.system;
  return below.role == Role::kSystem && who.role == Role::kTop;
}

// Who a router is, as bytes: what a HELLO, a WELCOME and an announcement have in common
// (PROTOCOL.md draws it).
inline constexpr std::size_t kWhoBytesMax = 27 + 63;

template <typename Enum>
bool get_enum(ByteReader& in, Enum last, Enum& value) {
  const auto number = in.get<std::uint8_t>();
  value = static_cast<Enum>(number);
  return number <= static_cast<std::uint8_t>(last);
}

void put(ByteWriter& out, const Identity& who);
// False for bytes that are nobody.
bool get(ByteReader& in, Identity& who);

// --- the datagrams

// Versions of this protocol that are understood here.
inline constexpr std::uint8_t kVersionMin = 1;
inline constexpr std::uint8_t kVersionMax = 1;

inline constexpr std::size_t kDatagramBase = 1200;      // every path carries this much
inline constexpr std::size_t kDatagramEthernet = 1472;  // of 1500 bytes, less IPv4 and UDP
inline constexpr std::size_t kDatagramMax = 8972;       // 9000 bytes of Ethernet less IP and UDP

enum class DatagramKind : std::uint8_t {
  kData = 1,
  kHello = 2,
  kWelcome = 3,
  kRefuse = 4,
  kReset = 5,
  kRetry = 6,
};

struct Hello {
  std::uint8_t version_min = kVersionMin;
  std::uint8_t version_max = kVersionMax;
  LinkKind kind = LinkKind::kSuper;  // what the receiver is to the sender
  std::uint64_t token = 0;           // the receiver puts this into DATA for the sender
  std::uint64_t resume = 0;          // the newest token the receiver has given; 0: none
  std::uint64_t cookie = 0;          // of the RETRY this one answers; 0: of none
  Duration keep_alive{};             // how often the sender says that it lives
  Identity who{};
};
// Filled up with zeros, and never shorter: so no answer is longer than its question.
inline constexpr std::size_t kHelloSize = 256;

// Say it again, with this: then I know that you are where you say.
struct Retry {
  std::uint64_t echo = 0;  // Hello::token
  std::uint64_t cookie = 0;
};

struct Welcome {
  std::uint8_t version = kVersionMax;
  bool resumed = false;     // the session of Hello::resume goes on
  std::uint64_t echo = 0;   // Hello::token
  std::uint64_t token = 0;  // the sender of the HELLO puts this into DATA
  Duration keep_alive{};
  Identity who{};
};

enum class RefuseCode : std::uint8_t {
  kVersion,
  kNotConfigured,
  kRole,
  kSystem,
  kDuplicateId,
  kWidths,
  kTooMany,
  kClasses,
};
constexpr std::array kRefuseCodes{
    core::Label<RefuseCode>{RefuseCode::kVersion, "version",
                            "no version of the protocol in common"},
    core::Label<RefuseCode>{RefuseCode::kNotConfigured, "not_configured",
                            "the other router has no [[link]] for this one"},
    core::Label<RefuseCode>{RefuseCode::kRole, "role", "the roles do not fit this kind of link"},
    core::Label<RefuseCode>{RefuseCode::kSystem, "system",
                            "the other router does not accept this system"},
    core::Label<RefuseCode>{RefuseCode::kDuplicateId, "duplicate_id",
                            "another living router has the same system and id"},
    core::Label<RefuseCode>{RefuseCode::kWidths, "widths",
                            "the widths of the address fields differ"},
    core::Label<RefuseCode>{RefuseCode::kTooMany, "too_many",
                            "the other router has as many links as it can hold"},
    core::Label<RefuseCode>{RefuseCode::kClasses, "classes",
                            "the thresholds of the priority classes differ"},
};
static_assert(core::complete(kRefuseCodes, RefuseCode::kClasses));
std::string_view name(RefuseCode code);
std::string_view sentence(RefuseCode code);

struct Refuse {
  std::uint8_t version_min = kVersionMin;
  std::uint8_t version_max = kVersionMax;
  std::uint64_t echo = 0;  // Hello::token
  RefuseCode code = RefuseCode::kVersion;
  core::Text<191> text{};  // names who and what
};

struct Reset {
  std::uint64_t token = 0;  // of the DATA that nobody here knows
};

using Datagram = std::variant<Hello, Retry, Welcome, Refuse, Reset>;

// Nothing for bytes that are none of these (DATA: frame.h). A HELLO of a version we do not know is
// one, with nothing but its versions and token filled in.
std::optional<Datagram> decode(std::span<std::byte> bytes);

inline constexpr std::size_t kControlDatagramMax = 512;  // none of these is longer
std::size_t encode(const Hello& hello, std::span<std::byte> to);
std::size_t encode(const Retry& retry, std::span<std::byte> to);
std::size_t encode(const Welcome& welcome, std::span<std::byte> to);
std::size_t encode(const Refuse& refuse, std::span<std::byte> to);
std::size_t encode(const Reset& reset, std::span<std::byte> to);

// --- the announcement

// What a router says of itself to all of its fleet, so that others find it without its address. It
// travels with DDS's discovery (the participant's user data).
struct Announcement {
  core::Text<63> fleet{};
  Identity who{};
  NetAddress dds{};               // where it was announced from; not in the bytes
  std::vector<NetAddress> udp{};  // where it takes datagrams; kAnnouncedAddressesMax at most

  bool operator==(const Announcement&) const = default;
};

inline constexpr std::size_t kAnnouncedAddressesMax = 16;
inline constexpr std::size_t kAnnouncementBytesMax = 512;

// Addresses beyond kAnnouncedAddressesMax are left out, and those with a scope, which means
// nothing on another host.
std::vector<std::byte> encode(const Announcement& announcement);
// Nothing for bytes that are none, among them those of a version that is not known here.
std::optional<Announcement> decode_announcement(std::span<const std::byte> bytes);

}  // namespace tims::link

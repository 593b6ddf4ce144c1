// The datagrams with which two routers find each other and open a session, byte for byte (drawn
// in PROTOCOL.md), and a router's description of itself in them and in its announcement to the
// fleet.
//
// HELLO, RETRY, WELCOME and REFUSE contain the magic number "TIMS" at a fixed offset, so that any
// version can report its supported versions to any other; RESET reports that its token is
// unknown. Everything carried over an established link is in DATA (frame.h).
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

// Integers in datagrams: little-endian, read and written with bounds checks. Neither class ever
// leaves its span: after an overrun a reader returns zeros and ok() is false.
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

// Precondition of every put: there is room (room()).
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::byte> to) : to_(to) {}

  [[nodiscard]] std::size_t size() const { return used_; }
  [[nodiscard]] std::size_t room() const { return to_.size() - used_; }
  [[nodiscard]] std::span<std::byte> written() const { return to_.first(used_); }

  template <typename... T>  // integers and enumerations
  void put(T... values) {
    (put_one(values), ...);
  }
  void put_bytes(std::span<const std::byte> bytes) {
    if (!bytes.empty()) std::memcpy(to_.data() + used_, bytes.data(), bytes.size());
    used_ += bytes.size();
  }
  void put_text(std::string_view text) { put_bytes(std::as_bytes(std::span(text))); }
  // The next `size` bytes, to be filled by the caller.
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

// Identity of a router. `epoch` is chosen at random when it starts.
struct Identity {
  std::uint64_t epoch = 0;
  Role role = Role::kSystem;
  std::uint16_t system = 0;
  std::uint16_t id = 0;
  Text<64> name{};
  AddressWidths widths{};
  std::uint32_t message_max = 0;  // bytes, header included
  core::PriorityClasses classes{};

  [[nodiscard]] Address address() const {
    return Address::of({.system = system, .instance = id}, widths);
  }
  bool operator==(const Identity&) const = default;
};

// True when `identity` can be the router above `below`: the system router of its system, or a
// top-level router.
inline bool is_above(const Identity& identity, const Identity& below) {
  if (below.role == Role::kSubsystem)
    return identity.role == Role::kSystem && identity.system == below.system;
  return below.role == Role::kSystem && identity.role == Role::kTop;
}

// The encoding of an identity, common to HELLO, WELCOME and announcements (drawn in PROTOCOL.md).
inline constexpr std::size_t kIdentityBytesMax = 27 + 63 + 2;

template <typename Enum>
bool get_enum(ByteReader& in, Enum last, Enum& value) {
  const auto number = in.get<std::uint8_t>();
  value = static_cast<Enum>(number);
  return number <= static_cast<std::uint8_t>(last);
}

void put(ByteWriter& out, const Identity& identity);
// Returns false when the bytes are not a valid identity.
bool get(ByteReader& in, Identity& identity);

// --- the datagrams

// Supported versions of this protocol.
inline constexpr std::uint8_t kVersionPlain = 1;   // without keys
inline constexpr std::uint8_t kVersionSealed = 2;  // with keys: the same session, sealed
inline constexpr std::uint8_t kVersionMin = kVersionPlain;
inline constexpr std::uint8_t kVersionMax = kVersionSealed;

inline constexpr std::size_t kDatagramMin = 548;        // every path carries them: IPv4's 576 bytes
inline constexpr std::size_t kDatagramBase = 1200;      // all but a few tunnels carry them
inline constexpr std::size_t kDatagramEthernet = 1472;  // 1500 bytes minus IPv4 and UDP headers
// 9000 bytes of Ethernet minus IP and UDP headers
inline constexpr std::size_t kDatagramMax = 8972;

enum class DatagramKind : std::uint8_t {
  kData = 1,
  kHello = 2,
  kWelcome = 3,
  kRefuse = 4,
  kReset = 5,
  kRetry = 6,
  kCrypto = 7,
};

// Of the plain version. In the sealed version it is the first message inside the handshake (WHO),
// and the HELLO before it is a SealedHello.
struct Hello {
  std::uint8_t version_min = kVersionPlain;
  std::uint8_t version_max = kVersionPlain;
  LinkKind kind = LinkKind::kSuper;  // the receiver's relation to the sender
  std::uint64_t token = 0;           // the receiver puts this into its DATA to the sender
  std::uint64_t resume = 0;          // the newest token issued by the receiver; 0: none
  std::uint64_t cookie = 0;          // from the RETRY being answered; 0: none
  Duration keep_alive{};             // the sender's keep-alive interval
  Identity identity{};
  std::uint8_t codecs = 0;  // what the sender can decompress (kCodecs in packing.h)
};
// Padded with zeros to at least this size, so that no answer is longer than its question.
inline constexpr std::size_t kHelloSize = 256;

// Says nothing about its sender.
struct SealedHello {
  std::uint64_t token = 0;
};

// Requests to repeat the HELLO with this cookie, which proves the sender's address.
struct Retry {
  std::uint64_t echo = 0;  // Hello::token
  std::uint64_t cookie = 0;
};

struct Welcome {
  std::uint8_t version = kVersionPlain;
  bool resumed = false;         // the session of Hello::resume continues
  std::uint8_t generation = 0;  // of the keys that the handshake has brought
  std::uint64_t echo = 0;       // Hello::token
  std::uint64_t token = 0;      // the sender of the HELLO puts this into its DATA
  Duration keep_alive{};
  Identity identity{};
  std::uint8_t codecs = 0;  // what the sender can decompress (kCodecs in packing.h)
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
  kCertificate,
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
    core::Label<RefuseCode>{RefuseCode::kCertificate, "certificate",
                            "the certificate of one of the two was not accepted"},
};
static_assert(core::complete(kRefuseCodes, RefuseCode::kCertificate));
std::string_view name(RefuseCode code);
std::string_view sentence(RefuseCode code);

struct Refuse {
  std::uint8_t version_min = kVersionMin;
  std::uint8_t version_max = kVersionMax;
  std::uint64_t echo = 0;  // Hello::token
  RefuseCode code = RefuseCode::kVersion;
  Text<192> text{};  // names the router and the reason
};

struct Reset {
  std::uint64_t token = 0;  // from the DATA whose token is unknown
};

// A part of a handshake's bytes, and an acknowledgement of those of the other side.
struct Crypto {
  bool from_accepting = false;
  std::uint64_t token = 0;   // of the HELLO
  std::uint64_t cookie = 0;  // from the RETRY; 0 from the accepting side
  std::uint32_t offset = 0;
  std::uint32_t acknowledged = 0;
  std::span<const std::byte> bytes{};
};
inline constexpr std::size_t kCryptoHeaderSize = 32;

using Datagram = std::variant<Hello, SealedHello, Retry, Welcome, Refuse, Reset, Crypto>;

// Empty for other bytes (DATA: frame.h). A HELLO of an unknown version is returned with only its
// versions and token filled in.
std::optional<Datagram> decode(std::span<std::byte> bytes);

// The WHO of a handshake.
std::optional<Hello> decode_who(std::span<const std::byte> bytes);

inline constexpr std::size_t kControlDatagramMax = 512;  // of these datagrams but CRYPTO
std::size_t encode(const Hello& hello, std::span<std::byte> to);
std::size_t encode(const Retry& retry, std::span<std::byte> to);
std::size_t encode(const Welcome& welcome, std::span<std::byte> to);
std::size_t encode(const Refuse& refuse, std::span<std::byte> to);
std::size_t encode(const Reset& reset, std::span<std::byte> to);
std::size_t encode(const SealedHello& hello, std::span<std::byte> to);
std::size_t encode(const Crypto& crypto, std::span<std::byte> to);  // kDatagramBase at most

// --- the announcement

// A router's announcement to its whole fleet, with which others find it without a configured
// address. It is part of DDS discovery (the participant's user data).
struct Announcement {
  Text<64> fleet{};
  Identity identity{};
  NetAddress dds{};               // source of the announcement; not encoded
  std::vector<NetAddress> udp{};  // where it receives datagrams; kAnnouncedAddressesMax at most

  bool operator==(const Announcement&) const = default;
};

inline constexpr std::size_t kAnnouncedAddressesMax = 16;
inline constexpr std::size_t kAnnouncementBytesMax = 512;

// Addresses beyond kAnnouncedAddressesMax are omitted, and those with a scope, which has no
// meaning on another host.
std::vector<std::byte> encode(const Announcement& announcement);
// Empty for invalid bytes and for unknown versions.
std::optional<Announcement> decode_announcement(std::span<const std::byte> bytes);

}  // namespace tims::link

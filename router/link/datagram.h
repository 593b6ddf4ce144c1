// The kinds of datagrams between two routers, byte for byte (PROTOCOL.md draws them).
//
// HELLO, RETRY, WELCOME and REFUSE begin with the word "TIMS", so that any version can tell any
// other what it speaks. DATA is the one that matters; RESET says that its token is not known here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>

#include "router/core/text.h"
#include "router/link/identity.h"
#include "tims/time.h"

namespace tims::link {

// Versions of this protocol that are understood here.
inline constexpr std::uint8_t kVersionMin = 1;
inline constexpr std::uint8_t kVersionMax = 1;

inline constexpr std::size_t kDatagramBase = 1200;      // every path carries this much
inline constexpr std::size_t kDatagramEthernet = 1472;  // of 1500 bytes, less IPv4 and UDP
inline constexpr std::size_t kDatagramMax = 8972;       // 9000 bytes of Ethernet less IP and UDP
inline constexpr std::size_t kDataHeaderSize = 16;

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

struct DataHeader {
  std::uint64_t token = 0;
  std::uint32_t packet = 0;  // the lower 32 bits of the packet's number
};
// A DATA datagram: its header and its frames (frame.h).
struct Data {
  DataHeader header{};
  std::span<std::byte> frames{};
};

using Datagram = std::variant<Data, Hello, Retry, Welcome, Refuse, Reset>;

// Nothing for bytes that are no datagram of ours. A HELLO of a version we do not know is one, with
// nothing but its versions and token filled in.
std::optional<Datagram> decode(std::span<std::byte> bytes);

inline constexpr std::size_t kControlDatagramMax = 512;  // none of these is longer
std::size_t encode(const Hello& hello, std::span<std::byte> to);
std::size_t encode(const Retry& retry, std::span<std::byte> to);
std::size_t encode(const Welcome& welcome, std::span<std::byte> to);
std::size_t encode(const Refuse& refuse, std::span<std::byte> to);
std::size_t encode(const Reset& reset, std::span<std::byte> to);
void encode(const DataHeader& header, std::span<std::byte, kDataHeaderSize> to);

}  // namespace tims::link

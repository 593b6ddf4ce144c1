// The words between a client and its router on one host: one SEQPACKET record each, over the Unix
// socket, numbers in the machine's own order. File descriptors travel beside a record.
//
//   client                                   router
//     Hello                            ->
//                                      <-    Welcome | Refused
//     OfferSegment  + memfd            ->                        (no answer)
//     Open[...] (+ wakers)             ->
//                                      <-    Opened[...]
//     Close[...]                       ->
//                                      <-    Closed
//     Lookup[...]                      ->
//                                      <-    Found (+ memfd, waker)       one for each address
//     UplinkRequest                    ->
//                                      <-    Uplink + memfd, eventfd
//                                      <-    Moved                (look this address up again)
//
// A client may have at most 16 segments in which it has opened nothing. With the last mailbox in
// it, and with an Open that is refused when there is none, the router forgets a segment: offer it
// again. Offering one, or opening a mailbox at its place, twice on one connection changes nothing.
// Who is back on a new connection, the old one closed, gets its writer and its addresses at once,
// and the router takes the mark `closed` off its mailboxes. What a client has put into its uplink
// before a record, or before it closes the connection, goes first; so the answer to a Close of
// nothing says that the router has taken all that was sent before. A router without free file
// descriptors refuses (kTooMany); it closes no connection for that. One client may use a quarter of
// them.
//
// Every decoder takes whatever came and says what is wrong with it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "tims/address.h"

namespace tims::wire {

inline constexpr std::uint16_t kLocalVersion = 3;
inline constexpr std::size_t kRecordBytesMax = 64 << 10;
inline constexpr std::size_t kBatchMax = 1024;  // mailboxes in one Open, Close or Lookup
inline constexpr std::size_t kNameMax = 31;
inline constexpr std::size_t kTextMax = 512;

// Where a mailbox lies: in which client's shared memory, at which byte.
struct MailboxPlace {
  std::uint64_t segment = 0;
  std::uint64_t offset = 0;
  bool operator==(const MailboxPlace&) const = default;
};

struct Hello {
  std::uint16_t version_min = kLocalVersion;
  std::uint16_t version_max = kLocalVersion;
  std::uint32_t writer = 0;  // the identity it had with the last router, 0: none
  std::string name;
};
struct Welcome {
  std::uint16_t version = kLocalVersion;
  std::uint32_t writer = 0;  // marks the slots this client is writing; never 0
  Address router;
  std::uint64_t epoch = 0;
  std::uint32_t message_max = 0;  // bytes, header included
  AddressWidths widths;           // of the fleet's addresses
};
struct Refused {
  std::string text;  // what, why, and what to do
};
struct OfferSegment {
  std::uint64_t segment = 0;  // chosen by the client, unique for it
};
struct OpenEntry {
  Address address = {};
  MailboxPlace place = {};
  bool has_waker = false;  // then the wakers (os/wakeup.h) come beside the record, in order
};
struct Open {
  std::vector<OpenEntry> entries;
};
enum class OpenStatus : std::uint32_t { kOk, kAddressInUse, kBadPlace, kTooMany, kNotTried };
struct OpenedEntry {
  Address address = {};
  OpenStatus status = OpenStatus::kOk;
};
struct Opened {
  std::vector<OpenedEntry> entries;
  // What is said of the first that is not open, behind its address: "belongs to pid 4711 (laser)".
  std::string text;
};
struct Close {
  std::vector<Address> addresses;
};
struct Closed {};
struct Lookup {
  std::vector<Address> addresses;
};
struct Found {
  Address address = {};
  bool local = false;       // false: send through the uplink
  MailboxPlace place = {};  // segment ids here are the router's, unique on this host
  bool has_waker = false;
};
struct UplinkRequest {};
struct Uplink {
  MailboxPlace place = {};
};
// A message came through the uplink although its receiver is on this host by now.
struct Moved {
  Address address = {};
};

using Record = std::variant<Hello, Welcome, Refused, OfferSegment, Open, Opened, Close, Closed,
                            Lookup, Found, UplinkRequest, Uplink, Moved>;

struct Packet {
  std::uint32_t request = 0;  // a client's number for a request, repeated in the answer
  Record record;
};

// Appends the record's bytes. Lists beyond kBatchMax and texts beyond their limits are cut.
void encode(const Packet& packet, std::vector<std::byte>& out);

// Nullopt and a reason for whatever is not exactly one record.
struct Decoded {
  std::optional<Packet> packet;
  std::string_view problem;
};
Decoded decode(std::span<const std::byte> bytes);

}  // namespace tims::wire

// The protocol between a client and the router of its host: each record is one SEQPACKET datagram
// on the Unix socket, with numbers in native byte order. File descriptors are sent with a record.
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
// A client may have at most 16 segments without an open mailbox. The router forgets a segment when
// its last mailbox is closed, or when an Open is refused and the segment has no mailbox: the client
// must offer it again. Offering a segment twice on one connection, or opening a mailbox twice at
// its place, has no effect. A client that reconnects after its old connection was closed gets its
// writer identity and its addresses immediately, and the router clears the `closed` flag of its
// mailboxes. Messages that a client put into its uplink before a record, or before it closes the
// connection, are processed first; the answer to an empty Close therefore states that the router
// has accepted all messages sent before. A router without free file descriptors refuses (kTooMany)
// but keeps the connection. One client may use a quarter of the descriptors.
//
// Every decoder accepts arbitrary bytes and reports what is wrong with them.
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

// Location of a mailbox: the shared memory of a client, and the byte offset in it.
struct MailboxPlace {
  std::uint64_t segment = 0;
  std::uint64_t offset = 0;
  bool operator==(const MailboxPlace&) const = default;
};

struct Hello {
  std::uint16_t version_min = kLocalVersion;
  std::uint16_t version_max = kLocalVersion;
  std::uint32_t writer = 0;  // the identity assigned by the last router, 0: none
  std::string name;
};
struct Welcome {
  std::uint16_t version = kLocalVersion;
  std::uint32_t writer = 0;  // marks the slots that this client is writing; never 0
  Address router;
  std::uint64_t epoch = 0;
  std::uint32_t message_max = 0;  // bytes, header included
  AddressWidths widths;           // of the fleet's addresses
};
struct Refused {
  std::string text;  // what failed, why, and what to do
};
struct OfferSegment {
  std::uint64_t segment = 0;  // chosen by the client, unique for it
};
struct OpenEntry {
  Address address = {};
  MailboxPlace place = {};
  bool has_waker = false;  // the wakers (os/wakeup.h) are sent with the record, in order
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
  // Reason for the first entry that is not open, to be printed after its address: "belongs to pid
  // 4711 (laser)".
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
  MailboxPlace place = {};  // the router's segment ids, unique on this host
  bool has_waker = false;
};
struct UplinkRequest {};
struct Uplink {
  MailboxPlace place = {};
};
// A message arrived through the uplink although its receiver is on this host now.
struct Moved {
  Address address = {};
};

using Record = std::variant<Hello, Welcome, Refused, OfferSegment, Open, Opened, Close, Closed,
                            Lookup, Found, UplinkRequest, Uplink, Moved>;

struct Packet {
  std::uint32_t request = 0;  // number chosen by the client, repeated in the answer
  Record record;
};

// Appends the record's bytes. Lists beyond kBatchMax and texts beyond their limits are truncated.
void encode(const Packet& packet, std::vector<std::byte>& out);

// Nullopt and a reason if the bytes are not exactly one record.
struct Decoded {
  std::optional<Packet> packet;
  std::string_view problem;
};
Decoded decode(std::span<const std::byte> bytes);

}  // namespace tims::wire

// What two routers say to each other in the control lane, byte for byte: messages as any others,
// with their meaning in the type.
//
//   WANT      number u32, hash u32                       I hold your table in this state: go on
//   SNAPSHOT  -                                          forget it: all of it follows
//   ADD       groups of: router u32, epoch u32, hops u8, 0 u8, count u16, count x address u32
//   REMOVE    address u32 ...
//   DONE      number u32, hash u32                       so far it is this state
//
// A table is numbered by its changes; its hash is the exclusive or over its mailboxes
// (ExportedTable).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "router/core/ids.h"
#include "router/link/bytes.h"
#include "tims/message.h"

namespace tims::link {

namespace control {
inline constexpr std::int8_t kWant = 1;
inline constexpr std::int8_t kSnapshot = 2;
inline constexpr std::int8_t kAdd = 3;
inline constexpr std::int8_t kRemove = 4;
inline constexpr std::int8_t kDone = 5;
}  // namespace control

struct TableState {
  std::uint32_t number = 0;
  std::uint32_t hash = 0;
  bool operator==(const TableState&) const = default;
};

// A control message in the making: its header and body.
class ControlMessage {
 public:
  static constexpr std::size_t kBodyMax = 16 << 10;

  explicit ControlMessage(std::int8_t type);

  void put(const TableState& state);
  void put(Address address);
  // Joins the group of the last address when it has the same origin.
  void put(Address address, const core::Origin& origin);
  [[nodiscard]] bool full() const { return bytes_.size() + 32 > kBodyMax; }
  [[nodiscard]] bool empty() const { return bytes_.size() == kHeaderSize; }

  // All of it, the header filled in.
  std::span<const std::byte> finish();

 private:
  void put_u32(std::uint32_t value);

  Header header_;
  std::vector<std::byte> bytes_;
  std::size_t group_ = 0;  // where the count of the open group stands; 0: none
  core::Origin origin_{};
  std::uint16_t count_ = 0;
};

// Reads them; false when the body is not what the type says.
bool read_state(std::span<const std::byte> body, TableState& state);
template <typename Visit>  // (Address)
bool read_addresses(std::span<const std::byte> body, Visit visit) {
  ByteReader in(body);
  while (!in.empty()) {
    const Address address(in.get<std::uint32_t>());
    if (!in.ok()) return false;
    visit(address);
  }
  return true;
}
template <typename Visit>  // (Address, const Origin&), with the hops as the other router counts
                           // them
bool read_announcements(std::span<const std::byte> body, Visit visit) {
  ByteReader in(body);
  while (!in.empty()) {
    core::Origin origin;
    origin.router = Address(in.get<std::uint32_t>());
    origin.epoch = in.get<std::uint32_t>();
    origin.hops = in.get<std::uint8_t>();
    in.get<std::uint8_t>();
    const auto count = in.get<std::uint16_t>();
    if (!in.ok() || count == 0) return false;
    for (std::size_t i = 0; i < count; ++i) {
      const Address address(in.get<std::uint32_t>());
      if (!in.ok()) return false;
      visit(address, origin);
    }
  }
  return true;
}

}  // namespace tims::link

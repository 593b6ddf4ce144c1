#include "router/link/control.h"

#include "wire/header.h"

namespace tims::link {

ControlMessage::ControlMessage(std::int8_t type) : header_{.type = type}, bytes_(kHeaderSize) {}

void ControlMessage::put_u32(std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8)
    bytes_.push_back(static_cast<std::byte>(value >> shift & 0xFF));
}

void ControlMessage::put(const TableState& state) {
  put_u32(state.number);
  put_u32(state.hash);
}

void ControlMessage::put(Address address) { put_u32(address.raw()); }

void ControlMessage::put(Address address, const core::Origin& origin) {
  if (group_ == 0 || origin_ != origin || count_ == 0xFFFF) {
    put_u32(origin.router.raw());
    put_u32(origin.epoch);
    bytes_.push_back(std::byte{origin.hops});
    bytes_.push_back(std::byte{0});
    group_ = bytes_.size();
    bytes_.resize(group_ + 2);
    origin_ = origin;
    count_ = 0;
  }
  ++count_;
  bytes_[group_] = static_cast<std::byte>(count_ & 0xFF);
  bytes_[group_ + 1] = static_cast<std::byte>(count_ >> 8);
  put(address);
}

std::span<const std::byte> ControlMessage::finish() {
  header_.length = static_cast<std::uint32_t>(bytes_.size());
  wire::encode_header(header_, std::span(bytes_).first<kHeaderSize>());
  return bytes_;
}

bool read_state(std::span<const std::byte> body, TableState& state) {
  ByteReader in(body);
  state.number = in.get<std::uint32_t>();
  state.hash = in.get<std::uint32_t>();
  return in.ok();
}

}  // namespace tims::link

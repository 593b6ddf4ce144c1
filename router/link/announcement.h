// What a router says of itself to all of its fleet, so that others find it without its address. It
// travels with DDS's discovery (the participant's user data).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "router/core/text.h"
#include "router/link/identity.h"
#include "router/link/net_address.h"

namespace tims::link {

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

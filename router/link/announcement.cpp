#include "router/link/announcement.h"

#include <algorithm>
#include <array>

#include "router/link/bytes.h"
#include "router/link/who.h"

namespace tims::link {
namespace {

constexpr std::string_view kMagic = "TIMS";
constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kAddressBytesMax = 1 + 2 + 16;
constexpr std::size_t kFleetMax = 63;
static_assert(kMagic.size() + 3 + kFleetMax + kWhoBytesMax +
                  kAnnouncedAddressesMax * kAddressBytesMax <=
              kAnnouncementBytesMax);

// The interface of a link-local address is this host's own matter.
bool is_for_others(const NetAddress& address) {
  return address && address.kind == PathKind::kUdp && address.scope == 0;
}

void put(ByteWriter& out, const NetAddress& address) {
  const auto ip = std::as_bytes(std::span(address.ip));
  out.put(address.is_v4() ? std::uint8_t{4} : std::uint8_t{6});
  out.put(address.port);
  out.put_bytes(address.is_v4() ? ip.last(4) : ip);
}

bool get(ByteReader& in, NetAddress& address) {
  const auto family = in.get<std::uint8_t>();
  if (family != 4 && family != 6) return false;
  const auto port = in.get<std::uint16_t>();
  address = NetAddress::v4(0, 0, 0, 0, port);
  const std::size_t size = family == 4 ? 4 : address.ip.size();
  const auto bytes = in.take(size);
  if (!in.ok()) return false;
  std::ranges::transform(bytes, address.ip.end() - static_cast<std::ptrdiff_t>(size),
                         std::to_integer<std::uint8_t>);
  return port != 0;
}

}  // namespace

std::vector<std::byte> encode(const Announcement& announcement) {
  std::vector<NetAddress> addresses;
  std::ranges::copy_if(announcement.udp, std::back_inserter(addresses), is_for_others);
  addresses.resize(std::min(addresses.size(), kAnnouncedAddressesMax));

  std::array<std::byte, kAnnouncementBytesMax> bytes{};
  ByteWriter out(bytes);
  out.put_text(kMagic);
  out.put(kVersion);
  out.put(static_cast<std::uint8_t>(addresses.size()));
  const std::string_view fleet = announcement.fleet.view();
  out.put(static_cast<std::uint8_t>(fleet.size()));
  out.put_text(fleet);
  put(out, announcement.who);
  for (const NetAddress& address : addresses) put(out, address);
  const auto written = out.written();
  return {written.begin(), written.end()};
}

std::optional<Announcement> decode_announcement(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  if (in.text(kMagic.size()) != kMagic || in.get<std::uint8_t>() != kVersion) return std::nullopt;
  const auto count = in.get<std::uint8_t>();
  const auto fleet_size = in.get<std::uint8_t>();
  if (count > kAnnouncedAddressesMax || fleet_size > kFleetMax) return std::nullopt;
  Announcement announcement;
  announcement.fleet = in.text(fleet_size);
  if (!get(in, announcement.who)) return std::nullopt;
  announcement.udp.resize(count);
  for (NetAddress& address : announcement.udp) {
    if (!get(in, address)) return std::nullopt;
  }
  if (!in.empty()) return std::nullopt;
  return announcement;
}

}  // namespace tims::link

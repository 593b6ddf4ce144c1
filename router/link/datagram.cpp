#include "router/link/datagram.h"

#include <algorithm>
#include <array>

namespace tims::link {
namespace {

static_assert(35 + kIdentityBytesMax + 1 <= kHelloSize);
// Answers are not longer than HELLO: WELCOME, and REFUSE with its longest sentence.
static_assert(26 + kIdentityBytesMax + 1 <= kHelloSize && 18 + 191 <= kHelloSize);

constexpr std::string_view kMagic = "TIMS";
constexpr int kKeepAliveMinMs = 10;

void put_ms(ByteWriter& out, Duration duration) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(duration).count();
  out.put(static_cast<std::uint16_t>(std::clamp<std::int64_t>(ms, kKeepAliveMinMs, 0xFFFF)));
}
// The interval has a lower bound so that a link does not time out immediately.
Duration get_ms(ByteReader& in) {
  return std::chrono::milliseconds(std::max<int>(in.get<std::uint16_t>(), kKeepAliveMinMs));
}

// Earlier routers send none: zeros follow their HELLO, and nothing their WELCOME.
std::uint8_t get_codecs(ByteReader& in) { return in.empty() ? 0 : in.get<std::uint8_t>(); }

void begin(ByteWriter& out, DatagramKind kind, std::uint8_t first, std::uint8_t second,
           std::uint8_t third = 0) {
  out.put(kind, first, second, third);
  out.put_text(kMagic);
}

bool get_rest(ByteReader& in, Hello& hello) {
  in.get(hello.resume, hello.cookie);
  hello.keep_alive = get_ms(in);
  const bool kind_known = get_enum(in, LinkKind::kSub, hello.kind) && hello.kind != LinkKind::kSub;
  if (!kind_known || !get(in, hello.identity)) return false;
  hello.codecs = get_codecs(in);
  return true;
}

std::optional<Datagram> decode_crypto(ByteReader in, std::uint8_t version, std::uint8_t flags) {
  Crypto crypto{.from_accepting = (flags & 1) != 0};
  in.get(crypto.token, crypto.cookie, crypto.offset, crypto.acknowledged);
  crypto.bytes = in.rest();
  if (!in.ok() || version != kVersionSealed) return std::nullopt;
  return crypto;
}

std::optional<Datagram> decode_hello(ByteReader in, std::uint8_t low, std::uint8_t high) {
  Hello hello{.version_min = low, .version_max = high};
  hello.token = in.get<std::uint64_t>();
  if (!in.ok() || hello.token == 0 || low > high) return std::nullopt;
  // The bytes after the token may differ in another version.
  if (low > kVersionMax || high < kVersionMin) return hello;
  if (low == kVersionSealed) return SealedHello{hello.token};
  if (!get_rest(in, hello)) return std::nullopt;
  return hello;
}

std::optional<Datagram> decode_welcome(ByteReader in, std::uint8_t version, std::uint8_t flags,
                                       std::uint8_t generation) {
  Welcome welcome{.version = version, .resumed = (flags & 1) != 0, .generation = generation};
  in.get(welcome.echo, welcome.token);
  welcome.keep_alive = get_ms(in);
  if (!get(in, welcome.identity) || welcome.token == 0) return std::nullopt;
  welcome.codecs = get_codecs(in);
  return welcome;
}

std::optional<Datagram> decode_refuse(ByteReader in, std::uint8_t low, std::uint8_t high) {
  Refuse refuse{.version_min = low, .version_max = high};
  refuse.echo = in.get<std::uint64_t>();
  const bool known = get_enum(in, RefuseCode::kCertificate, refuse.code);
  const auto size = in.get<std::uint8_t>();
  refuse.text = in.text(size);
  if (!in.ok() || !known) return std::nullopt;
  return refuse;
}

// Bit of the role: the upper bytes of system and id follow the name. Routers of older versions,
// which do not know it, ignore the identity.
constexpr std::uint8_t kWideIds = 0x80;
bool fits(std::uint32_t value, std::uint8_t bits) { return value >> bits == 0; }

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kAddressBytesMax = 1 + 2 + 16;
constexpr std::size_t kFleetMax = 63;
static_assert(kMagic.size() + 3 + kFleetMax + kIdentityBytesMax +
                  kAnnouncedAddressesMax * kAddressBytesMax <=
              kAnnouncementBytesMax);

// Link-local addresses are excluded: their interface is meaningful on this host only.
bool is_for_others(const NetAddress& address) {
  return address && address.kind == PathKind::kUdp && address.scope == 0;
}

void put(ByteWriter& out, const NetAddress& address) {
  const auto ip = std::as_bytes(std::span(address.ip));
  out.put(address.is_v4() ? std::uint8_t{4} : std::uint8_t{6}, address.port);
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

void put(ByteWriter& out, const Identity& identity) {
  const AddressWidths& w = identity.widths;
  const bool wide = identity.system > 0xFF || identity.id > 0xFF;
  const auto role = static_cast<std::uint8_t>(identity.role);
  out.put(identity.epoch, static_cast<std::uint8_t>(wide ? role | kWideIds : role),
          static_cast<std::uint8_t>(identity.system), static_cast<std::uint8_t>(identity.id),
          static_cast<std::uint8_t>(identity.name.view().size()));
  out.put(w.system, w.class_id, w.instance, w.local, identity.message_max);
  for (const std::uint8_t first : identity.classes.from) out.put(first);
  out.put_text(identity.name.view());
  if (wide)
    out.put(static_cast<std::uint8_t>(identity.system >> 8),
            static_cast<std::uint8_t>(identity.id >> 8));
}

bool get(ByteReader& in, Identity& identity) {
  identity.epoch = in.get<std::uint64_t>();
  const auto role = in.get<std::uint8_t>();
  const bool wide = (role & kWideIds) != 0;
  identity.role = static_cast<Role>(role & ~kWideIds);
  AddressWidths& w = identity.widths;
  auto system = in.get<std::uint8_t>();
  auto id = in.get<std::uint8_t>();
  identity.system = system;
  identity.id = id;
  std::uint8_t name_size = 0;
  in.get(name_size, w.system, w.class_id, w.instance, w.local, identity.message_max);
  for (std::uint8_t& first : identity.classes.from) in.get(first);
  identity.name = in.text(name_size);
  if (wide) {
    in.get(system, id);
    identity.system = static_cast<std::uint16_t>(identity.system | system << 8);
    identity.id = static_cast<std::uint16_t>(identity.id | id << 8);
  }
  const bool valid = in.ok() && identity.role <= Role::kTop && w.valid() &&
                     identity.classes.valid() && identity.epoch != 0;
  if (!valid) return false;
  identity.classes = identity.classes.at(w);
  return fits(identity.system, w.system) && fits(identity.id, w.instance);
}

std::string_view name(RefuseCode code) { return core::label(kRefuseCodes, code).name; }
std::string_view sentence(RefuseCode code) { return core::label(kRefuseCodes, code).sentence; }

std::optional<Datagram> decode(std::span<std::byte> bytes) {
  ByteReader in(bytes);
  const auto kind = static_cast<DatagramKind>(in.get<std::uint8_t>());
  const auto first = in.get<std::uint8_t>();
  const auto second = in.get<std::uint8_t>();
  const auto third = in.get<std::uint8_t>();
  if (!in.ok()) return std::nullopt;
  if (in.text(kMagic.size()) != kMagic) return std::nullopt;
  switch (kind) {
    case DatagramKind::kHello:
      if (bytes.size() < kHelloSize) break;
      return decode_hello(in, first, second);
    case DatagramKind::kRetry: {
      const Retry retry{in.get<std::uint64_t>(), in.get<std::uint64_t>()};
      if (in.ok()) return retry;
      break;
    }
    case DatagramKind::kWelcome:
      return decode_welcome(in, first, second, third);
    case DatagramKind::kCrypto:
      return decode_crypto(in, first, second);
    case DatagramKind::kRefuse:
      return decode_refuse(in, first, second);
    case DatagramKind::kReset: {
      const Reset reset{in.get<std::uint64_t>()};
      if (in.ok()) return reset;
      break;
    }
    default:
      break;
  }
  return std::nullopt;
}

std::size_t encode(const Hello& hello, std::span<std::byte> to) {
  ByteWriter out(to);
  begin(out, DatagramKind::kHello, hello.version_min, hello.version_max);
  out.put(hello.token, hello.resume, hello.cookie);
  put_ms(out, hello.keep_alive);
  out.put(hello.kind);
  put(out, hello.identity);
  out.put(hello.codecs);
  std::ranges::fill(out.reserve(kHelloSize - out.size()), std::byte{0});
  return out.size();
}

std::size_t encode(const Retry& retry, std::span<std::byte> to) {
  ByteWriter out(to);
  begin(out, DatagramKind::kRetry, kVersionMin, kVersionMax);
  out.put(retry.echo, retry.cookie);
  return out.size();
}

std::size_t encode(const Welcome& welcome, std::span<std::byte> to) {
  ByteWriter out(to);
  begin(out, DatagramKind::kWelcome, welcome.version, welcome.resumed ? 1 : 0, welcome.generation);
  out.put(welcome.echo, welcome.token);
  put_ms(out, welcome.keep_alive);
  put(out, welcome.identity);
  out.put(welcome.codecs);
  return out.size();
}

std::size_t encode(const Refuse& refuse, std::span<std::byte> to) {
  ByteWriter out(to);
  begin(out, DatagramKind::kRefuse, refuse.version_min, refuse.version_max);
  const std::string_view text = refuse.text.view();
  out.put(refuse.echo, refuse.code, static_cast<std::uint8_t>(text.size()));
  out.put_text(text);
  return out.size();
}

std::size_t encode(const Reset& reset, std::span<std::byte> to) {
  ByteWriter out(to);
  begin(out, DatagramKind::kReset, 0, 0);
  out.put(reset.token);
  return out.size();
}

std::size_t encode(const SealedHello& hello, std::span<std::byte> to) {
  ByteWriter out(to);
  begin(out, DatagramKind::kHello, kVersionSealed, kVersionSealed);
  out.put(hello.token);
  std::ranges::fill(out.reserve(kHelloSize - out.size()), std::byte{0});
  return out.size();
}

std::size_t encode(const Crypto& crypto, std::span<std::byte> to) {
  ByteWriter out(to);
  begin(out, DatagramKind::kCrypto, kVersionSealed, crypto.from_accepting ? 1 : 0);
  out.put(crypto.token, crypto.cookie, crypto.offset, crypto.acknowledged);
  out.put_bytes(crypto.bytes);
  return out.size();
}

std::optional<Hello> decode_who(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  Hello who;
  DatagramKind kind{};
  if (!get_enum(in, DatagramKind::kCrypto, kind) || kind != DatagramKind::kHello)
    return std::nullopt;
  in.get(who.version_min, who.version_max);
  in.get<std::uint8_t>();
  if (in.text(kMagic.size()) != kMagic || who.version_min != kVersionSealed) return std::nullopt;
  who.token = in.get<std::uint64_t>();
  if (who.token == 0 || !get_rest(in, who)) return std::nullopt;
  return who;
}

std::vector<std::byte> encode(const Announcement& announcement) {
  std::vector<NetAddress> addresses;
  std::ranges::copy_if(announcement.udp, std::back_inserter(addresses), is_for_others);
  addresses.resize(std::min(addresses.size(), kAnnouncedAddressesMax));

  std::array<std::byte, kAnnouncementBytesMax> bytes{};
  ByteWriter out(bytes);
  out.put_text(kMagic);
  const std::string_view fleet = announcement.fleet.view();
  out.put(kVersion, static_cast<std::uint8_t>(addresses.size()),
          static_cast<std::uint8_t>(fleet.size()));
  out.put_text(fleet);
  put(out, announcement.identity);
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
  if (!get(in, announcement.identity)) return std::nullopt;
  announcement.udp.resize(count);
  for (NetAddress& address : announcement.udp) {
    if (!get(in, address)) return std::nullopt;
  }
  if (!in.empty()) return std::nullopt;
  return announcement;
}

}  // namespace tims::link

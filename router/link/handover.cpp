#include "router/link/handover.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "router/core/random.h"

namespace tims::link {
namespace {

constexpr std::string_view kMagicText = "TIMSLNKS";
constexpr std::size_t kHeadBytes = 24;

// Finds accidental damage; who could alter it on purpose has the router's rights.
std::uint64_t checksum(std::span<const std::byte> bytes) {
  std::uint64_t sum = bytes.size();
  for (std::size_t at = 0; at < bytes.size(); at += sizeof sum) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min(sizeof word, bytes.size() - at));
    sum = core::spread(sum ^ word) + at;
  }
  return sum;
}

void put_addresses(StateWriter& out, std::span<const Address> addresses) {
  out.put(static_cast<std::uint32_t>(addresses.size()));
  for (const Address address : addresses) out.put(address.raw());
}

std::vector<Address> get_addresses(StateReader& in) {
  const auto count = in.get<std::uint32_t>();
  std::vector<Address> addresses;
  if (count > in.rest().size() / sizeof(std::uint32_t)) {
    (void)in.take(in.rest().size() + 1);  // fails
    return addresses;
  }
  addresses.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) addresses.emplace_back(in.get<std::uint32_t>());
  return addresses;
}

}  // namespace

void StateWriter::put_address(const NetAddress& address) {
  for (const std::uint8_t byte : address.ip) put(byte);
  put(address.port, address.scope, address.kind);
}

void StateWriter::put_identity(const Identity& identity) {
  std::array<std::byte, kIdentityBytesMax> room{};
  ByteWriter writer(room);
  link::put(writer, identity);
  put_bytes(writer.written());
}

bool StateReader::address(NetAddress& address) {
  for (std::uint8_t& byte : address.ip) get(byte);
  get(address.port, address.scope);
  return get_enum(*this, PathKind::kTcp, address.kind) && ok();
}

bool StateReader::identity(Identity& identity) {
  ByteReader in(bytes());
  return link::get(in, identity) && in.empty() && ok();
}

std::vector<std::byte> Handover::encode() const {
  StateWriter body;
  body.put(at, table_number);
  body.put_identity(self);
  put_addresses(body, exported);
  put_addresses(body, mailboxes);
  body.put_bytes(links);
  StateWriter all;
  for (const char c : kMagicText) all.put(c);
  all.put(kVersion, static_cast<std::uint32_t>(body.bytes().size()), checksum(body.bytes()));
  all.bytes().insert(all.bytes().end(), body.bytes().begin(), body.bytes().end());
  return std::move(all.bytes());
}

Result<Handover> Handover::decode(Time now, std::span<const std::byte> bytes) {
  const auto wrong = [](const std::string& why) { return Error(Errc::kBadLayout, why); };
  StateReader in(now, bytes);
  if (bytes.size() < kHeadBytes || in.ByteReader::text(kMagicText.size()) != kMagicText)
    return wrong("it is none");
  const auto version = in.get<std::uint32_t>();
  if (version != kVersion)
    return wrong("it has layout " + std::to_string(version) + ", this program has " +
                 std::to_string(kVersion));
  const auto size = in.get<std::uint32_t>();
  const auto sum = in.get<std::uint64_t>();
  if (size != in.rest().size() || sum != checksum(in.rest())) return wrong("it is damaged");
  Handover read;
  read.at = Time{Duration(in.get<std::int64_t>())};
  read.table_number = in.get<std::uint32_t>();
  const bool valid = in.identity(read.self);
  read.exported = get_addresses(in);
  read.mailboxes = get_addresses(in);
  const auto links = in.bytes();
  read.links.assign(links.begin(), links.end());
  if (!valid || !in.ok() || !in.empty() || !std::ranges::is_sorted(read.exported))
    return wrong("it is damaged");
  if (read.at > now || now - read.at > kAgeMax) return wrong("it is too old");
  return read;
}

}  // namespace tims::link

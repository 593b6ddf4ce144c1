#include "router/io/dds/helper_protocol.h"

#include <algorithm>
#include <string>

namespace tims::io::helper {
namespace {

using link::ByteReader;
using link::NetAddress;

constexpr std::size_t kTextMax = 4096;

// A ByteWriter whose overrun is an error and not a bug: the texts have no common bound.
class Writer {
 public:
  explicit Writer(std::span<std::byte> to) : out_(to) {}

  template <typename... T>
  void put(T... values) {
    if (has_room((sizeof(T) + ...))) out_.put(values...);
  }
  void bytes(std::span<const std::byte> bytes) {
    if (has_room(bytes.size())) out_.put_bytes(bytes);
  }
  void text(std::string_view text) {
    const std::string_view some = text.substr(0, kTextMax);
    put(static_cast<std::uint16_t>(some.size()));
    bytes(std::as_bytes(std::span(some)));
  }
  void address(const NetAddress& address) {
    put(static_cast<std::uint8_t>(address.kind), address.port, address.scope);
    bytes(std::as_bytes(std::span(address.ip)));
  }
  void addresses(std::span<const NetAddress> all) {
    put(static_cast<std::uint16_t>(all.size()));
    for (const NetAddress& one : all) address(one);
  }
  void announcement(const link::Announcement& announcement) {
    address(announcement.dds);
    bytes(link::encode(announcement));
  }
  [[nodiscard]] std::size_t size() const { return ok_ ? out_.size() : 0; }

 private:
  bool has_room(std::size_t size) {
    ok_ = ok_ && out_.room() >= size;
    return ok_;
  }

  link::ByteWriter out_;
  bool ok_ = true;
};

std::string get_text(ByteReader& in) {
  const auto size = in.get<std::uint16_t>();
  return std::string(in.text(size));
}

NetAddress get_address(ByteReader& in) {
  NetAddress address;
  const bool dds = in.get<std::uint8_t>() == static_cast<std::uint8_t>(link::PathKind::kDds);
  address.kind = dds ? link::PathKind::kDds : link::PathKind::kUdp;
  in.get(address.port, address.scope);
  const auto ip = in.take(address.ip.size());
  std::ranges::transform(ip, address.ip.begin(), std::to_integer<std::uint8_t>);
  return address;
}

// Of another router. The helper believes whoever is on the network, and so may say anything; other
// paths than its own are not its business.
std::optional<NetAddress> get_dds_address(ByteReader& in) {
  const NetAddress address = get_address(in);
  return address.kind == link::PathKind::kDds ? std::optional(address) : std::nullopt;
}

std::vector<NetAddress> get_addresses(ByteReader& in) {
  std::vector<NetAddress> addresses;
  for (auto count = in.get<std::uint16_t>(); count > 0 && in.ok(); --count)
    addresses.push_back(get_address(in));
  return addresses;
}

// Takes the rest of the record.
std::optional<link::Announcement> get_announcement(ByteReader& in) {
  const NetAddress dds = get_address(in);
  auto announcement = link::decode_announcement(in.take(in.rest().size()));
  if (announcement) announcement->dds = dds;
  return announcement;
}

void put(Writer& out, const DdsSettings& settings) {
  out.text(settings.fleet);
  out.put(static_cast<std::uint32_t>(settings.domain), settings.multicast,
          static_cast<std::uint16_t>(settings.peers.size()));
  for (const std::string& peer : settings.peers) out.text(peer);
  out.text(settings.discovery_server);
  out.text(settings.interface);
  out.text(settings.profiles);
  out.put(std::int64_t{settings.lease.count()}, settings.message_max, settings.history,
          std::int64_t{settings.heartbeat.count()});
}

DdsSettings get_settings(ByteReader& in) {
  DdsSettings settings;
  settings.fleet = get_text(in);
  settings.domain = in.get<std::uint32_t>();
  settings.multicast = in.get<std::uint8_t>() != 0;
  for (auto count = in.get<std::uint16_t>(); count > 0 && in.ok(); --count)
    settings.peers.push_back(get_text(in));
  settings.discovery_server = get_text(in);
  settings.interface = get_text(in);
  settings.profiles = get_text(in);
  settings.lease = Duration(in.get<std::int64_t>());
  in.get(settings.message_max, settings.history);
  settings.heartbeat = Duration(in.get<std::int64_t>());
  return settings;
}

// The first byte of a record is its place in the variant.
struct Encoder {
  Writer& out;

  void operator()(const Start& start) const {
    put(out, start.settings);
    out.announcement(start.self);
  }
  void operator()(const Restart& restart) const { out.announcement(restart.self); }
  void operator()(const Connect& connect) const { out.address(connect.to); }
  void operator()(const link::Burst& burst) const {
    out.address(burst.to);
    out.put(static_cast<std::uint32_t>(burst.datagram_size), burst.dscp);
    out.bytes(burst.bytes);
  }
  void operator()(const Stop&) const {}
  void operator()(const Started& started) const { out.text(started.error); }
  void operator()(const Report& report) const {
    const DdsEngine::Counters& c = report.counters;
    out.put(static_cast<std::uint8_t>(report.state));
    out.address(report.address);
    out.addresses(report.host);
    out.text(report.last_error);
    out.put(c.samples_out, c.bytes_out, c.datagrams_out, c.samples_in, c.bytes_in, c.datagrams_in,
            c.strange, c.refused, c.unmatched, c.waiting_bytes);
  }
  void operator()(const Arrived& arrived) const {
    out.address(arrived.from);
    out.bytes(arrived.batch);
  }
  void operator()(const Announced& announced) const { out.announcement(announced.announcement); }
  void operator()(const Gone& gone) const { out.address(gone.dds); }
};

std::optional<Record> get_report(ByteReader& in) {
  Report report;
  const auto state = in.get<std::uint8_t>();
  if (state > static_cast<std::uint8_t>(DdsEngine::State::kUp)) return std::nullopt;
  report.state = static_cast<DdsEngine::State>(state);
  report.address = get_address(in);
  report.host = get_addresses(in);
  report.last_error = get_text(in);
  DdsEngine::Counters& c = report.counters;
  in.get(c.samples_out, c.bytes_out, c.datagrams_out, c.samples_in, c.bytes_in, c.datagrams_in,
         c.strange, c.refused, c.unmatched, c.waiting_bytes);
  return report;
}

std::optional<Record> get_burst(ByteReader& in, std::span<std::byte> all) {
  link::Burst burst{.to = get_address(in)};
  burst.datagram_size = in.get<std::uint32_t>();
  burst.dscp = in.get<std::uint8_t>();
  burst.bytes = all.last(in.rest().size());
  const bool good = in.ok() && burst.datagram_size > 0 && !burst.bytes.empty() &&
                    burst.datagram_size <= link::kDatagramMax &&
                    burst.bytes.size() <= link::kBurstBytesMax &&
                    burst.count() <= link::kBurstDatagramsMax;
  in.take(in.rest().size());
  return good ? std::optional<Record>(burst) : std::nullopt;
}

std::optional<Record> get_arrived(ByteReader& in, std::span<std::byte> all) {
  const auto from = get_dds_address(in);
  if (!from) return std::nullopt;
  const Arrived arrived{.from = *from, .batch = all.last(in.rest().size())};
  in.take(in.rest().size());
  return link::Batch(arrived.batch).valid() ? std::optional<Record>(arrived) : std::nullopt;
}

std::optional<Record> get_restart(ByteReader& in) {
  auto self = get_announcement(in);
  return self ? std::optional<Record>(Restart{std::move(*self)}) : std::nullopt;
}

std::optional<Record> get_announced(ByteReader& in) {
  auto announcement = get_announcement(in);
  if (!announcement || announcement->dds.kind != link::PathKind::kDds) return std::nullopt;
  return Announced{std::move(*announcement)};
}

std::optional<Record> get_gone(ByteReader& in) {
  const auto dds = get_dds_address(in);
  return dds ? std::optional<Record>(Gone{*dds}) : std::nullopt;
}

std::optional<Record> get_record(std::size_t kind, ByteReader& in, std::span<std::byte> all) {
  switch (kind) {
    case 0: {
      DdsSettings settings = get_settings(in);
      auto self = get_announcement(in);
      if (!self) return std::nullopt;
      return Start{std::move(settings), std::move(*self)};
    }
    case 1:
      return get_restart(in);
    case 2:
      return Connect{get_address(in)};
    case 3:
      return get_burst(in, all);
    case 4:
      return Stop{};
    case 5:
      return Started{get_text(in)};
    case 6:
      return get_report(in);
    case 7:
      return get_arrived(in, all);
    case 8:
      return get_announced(in);
    case 9:
      return get_gone(in);
    default:
      return std::nullopt;
  }
}

}  // namespace

std::size_t encode(const Record& record, std::span<std::byte> to) {
  Writer out(to);
  out.put(static_cast<std::uint8_t>(record.index()));
  std::visit(Encoder{out}, record);
  return out.size();
}

std::optional<Record> decode(std::span<std::byte> bytes) {
  ByteReader in(bytes);
  const auto kind = in.get<std::uint8_t>();
  auto record = get_record(kind, in, bytes);
  if (!in.ok() || !in.empty()) return std::nullopt;
  return record;
}

}  // namespace tims::io::helper

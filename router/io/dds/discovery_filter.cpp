#include "router/io/dds/discovery_filter.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "router/link/datagram.h"

namespace tims::io {
namespace {

using link::ByteReader;
using link::ByteWriter;
using link::DdsParticipant;

constexpr std::size_t kHeaderBytes = 20;  // "RTPS", version, vendor, GUID prefix
constexpr std::size_t kPrefixAt = 8;
constexpr std::uint8_t kInfoDestination = 0x0E;
constexpr std::uint8_t kInfoTimestamp = 0x09;
constexpr std::uint8_t kHeartbeat = 0x07;
constexpr std::uint8_t kPad = 0x01;
constexpr std::uint8_t kData = 0x15;
constexpr std::uint8_t kLittleEndian = 0x01;  // flags of a submessage
constexpr std::uint8_t kInlineQos = 0x02;
constexpr std::uint8_t kPayload = 0x04;
constexpr std::uint16_t kHeartbeatBytes = 28;
constexpr std::array kVersionAndVendor{std::byte{2}, std::byte{2}, std::byte{1}, std::byte{15}};
constexpr std::array kParticipantWriter{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0xC2}};

constexpr std::uint16_t kSentinel = 0x0001;
constexpr std::uint16_t kLease = 0x0002;
constexpr std::uint16_t kUserData = 0x002C;
constexpr std::uint16_t kMetatrafficUnicast = 0x0032;
constexpr std::uint16_t kStatusInfo = 0x0071;
constexpr std::byte kDisposedOrUnregistered{0x03};
constexpr std::int32_t kUdpV4 = 1;
constexpr std::size_t kLocatorBytes = 24;
constexpr std::size_t kLocatorsMax = 8;

// Integers in either byte order.
class Input {
 public:
  Input(std::span<const std::byte> bytes, bool little) : bytes_(bytes), little_(little) {}

  template <std::unsigned_integral T>
  T get() {
    const T value = bytes_.get<T>();
    if (little_) return value;
    T swapped = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      swapped = static_cast<T>(swapped << 8 | (value >> (8 * i) & 0xFF));
    return swapped;
  }
  std::span<const std::byte> take(std::size_t size) { return bytes_.take(size); }
  Input part(std::size_t size) { return {take(size), little_}; }
  [[nodiscard]] bool ok() const { return bytes_.ok(); }
  [[nodiscard]] bool empty() const { return bytes_.empty(); }
  [[nodiscard]] std::span<const std::byte> rest() const { return bytes_.rest(); }

 private:
  ByteReader bytes_;
  bool little_;
};

DdsParticipant participant_in(std::span<const std::byte> bytes) {
  DdsParticipant id{};
  std::transform(bytes.begin(), bytes.begin() + id.size(), id.begin(),
                 std::to_integer<std::uint8_t>);
  return id;
}

// Calls visit(id, value) for each parameter up to the last; returns the bytes after it.
template <typename Visit>
std::span<const std::byte> for_each_parameter(Input in, Visit visit) {
  while (!in.empty()) {
    const auto id = in.get<std::uint16_t>();
    const Input value = in.part(in.get<std::uint16_t>());
    if (!in.ok() || id == kSentinel) break;
    visit(id, value);
  }
  return in.rest();
}

Duration lease_in(Input in) {
  const auto seconds = in.get<std::uint32_t>();
  const auto fraction = in.get<std::uint32_t>();
  return std::chrono::seconds(seconds & 0x7FFFFFFF) +
         Duration(std::uint64_t{fraction} * 1'000'000'000 >> 32);
}

void add_locator(Input in, std::vector<link::NetAddress>& to) {
  if (in.rest().size() < kLocatorBytes || to.size() == kLocatorsMax) return;
  const bool is_udp = in.get<std::uint32_t>() == kUdpV4;
  const auto port = static_cast<std::uint16_t>(in.get<std::uint32_t>());
  const auto ip = in.take(16).last(4);
  const auto octet = [&](std::size_t i) { return std::to_integer<std::uint8_t>(ip[i]); };
  if (is_udp && port != 0)
    to.push_back(link::NetAddress::v4(octet(0), octet(1), octet(2), octet(3), port));
}

RtpsMessage::Announced read_announced(std::span<const std::byte> payload) {
  RtpsMessage::Announced announced;
  if (payload.size() < 4) return announced;
  const bool little = payload[1] == std::byte{3};  // PL_CDR_LE
  for_each_parameter({payload.subspan(4), little}, [&](std::uint16_t id, Input value) {
    if (id == kLease) announced.lease = lease_in(value);
    if (id == kMetatrafficUnicast) add_locator(value, announced.metatraffic);
    if (id == kUserData) announced.user_data = value.take(value.get<std::uint32_t>());
  });
  return announced;
}

void read_data(Input in, std::uint8_t flags, RtpsMessage& message) {
  (void)in.get<std::uint16_t>();
  Input head = in.part(in.get<std::uint16_t>());  // up to the inline QoS
  (void)head.take(4);                             // the reader
  if (!std::ranges::equal(head.take(4), kParticipantWriter) || !in.ok()) return;
  std::span<const std::byte> payload = in.rest();
  if ((flags & kInlineQos) != 0)
    payload = for_each_parameter(in, [&](std::uint16_t id, Input value) {
      if (id == kStatusInfo && value.rest().size() >= 4)
        message.ends = (value.rest()[3] & kDisposedOrUnregistered) != std::byte{0};
    });
  if ((flags & kPayload) != 0 && !message.ends) message.announced = read_announced(payload);
}

// The library applies its own lease to the participants it has discovered, and may receive them
// on other paths.
constexpr int kLeasesAdmitted = 3;

}  // namespace

// --- messages

std::optional<DdsParticipant> rtps_sender(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  if (in.text(4) != "RTPS" || bytes.size() < kHeaderBytes) return std::nullopt;
  return participant_in(bytes.subspan(kPrefixAt));
}

std::optional<RtpsMessage> parse_rtps(std::span<const std::byte> bytes) {
  const auto sender = rtps_sender(bytes);
  if (!sender) return std::nullopt;
  RtpsMessage message{.from = *sender};
  for (auto rest = bytes.subspan(kHeaderBytes); rest.size() >= 4;) {
    const auto kind = std::to_integer<std::uint8_t>(rest[0]);
    const auto flags = std::to_integer<std::uint8_t>(rest[1]);
    const bool little = (flags & kLittleEndian) != 0;
    std::size_t size = Input(rest.subspan(2), little).get<std::uint16_t>();
    rest = rest.subspan(4);
    // The last submessage may have size 0: it extends to the end of the message.
    if (size == 0 && kind != kPad && kind != kInfoTimestamp) size = rest.size();
    if (size > rest.size()) break;
    const auto body = rest.first(size);
    if (kind == kInfoDestination && size >= std::tuple_size_v<DdsParticipant>)
      message.to = participant_in(body);
    if (kind == kData) read_data({body, little}, flags, message);
    rest = rest.subspan(size);
  }
  return message;
}

std::array<std::byte, 68> encode(const RtpsHeartbeat& heartbeat) {
  std::array<std::byte, 68> bytes{};
  ByteWriter out(bytes);
  out.put_text("RTPS");
  out.put_bytes(kVersionAndVendor);
  out.put_bytes(std::as_bytes(std::span(heartbeat.from)));
  out.put(kInfoDestination, kLittleEndian, static_cast<std::uint16_t>(heartbeat.to.size()));
  out.put_bytes(std::as_bytes(std::span(heartbeat.to)));
  out.put(kHeartbeat, kLittleEndian, kHeartbeatBytes, std::uint32_t{0});  // for any reader there
  out.put_bytes(std::as_bytes(std::span(heartbeat.writer)));
  for (const std::uint64_t number : {heartbeat.first, heartbeat.last})
    out.put(static_cast<std::uint32_t>(number >> 32), static_cast<std::uint32_t>(number));
  out.put(heartbeat.count);
  return bytes;
}

std::vector<std::byte> directed(std::span<const std::byte> message, const DdsParticipant& to) {
  const auto header = message.first(kHeaderBytes);
  std::vector<std::byte> made(header.begin(), header.end());
  made.reserve(message.size() + 4 + to.size());
  for (const std::size_t octet :
       {std::size_t{kInfoDestination}, std::size_t{kLittleEndian}, to.size(), std::size_t{0}})
    made.push_back(static_cast<std::byte>(octet));
  for (const std::uint8_t octet : to) made.push_back(static_cast<std::byte>(octet));
  const auto rest = message.subspan(kHeaderBytes);
  made.insert(made.end(), rest.begin(), rest.end());
  return made;
}

// --- admission of participants

DiscoveryFilter::Verdict DiscoveryFilter::on_message(Time now, std::span<const std::byte> bytes,
                                                     bool multicast) {
  const auto message = parse_rtps(bytes);
  if (!message || message->from == own_) return {};
  const auto known = routers_.find(message->from);
  const bool is_known = known != routers_.end();
  if (is_known && known->second.admitted) {
    known->second.last_received = now;
    return {.passes = true};
  }
  Verdict verdict;
  if (message->ends) {
    if (is_known) verdict.gone = message->from;
    routers_.erase(message->from);
  } else if (message->announced) {
    auto announcement = link::decode_announcement(message->announced->user_data);
    if (!announcement || announcement->fleet != self_.fleet ||
        announcement->identity.epoch == self_.identity.epoch)
      return verdict;
    announcement->dds = link::NetAddress::dds(message->from);
    on_announced(now, message->from, bytes, *announcement, message->announced->lease, verdict);
    // A router that looks for one in our role is answered immediately, and so is one that announces
    // itself by unicast, because multicast may not reach it. A message directed to us alone is
    // already an answer.
    const bool must_answer = !multicast || link::is_above(self_.identity, announcement->identity);
    if (wanted_.contains(message->from)) {
      verdict.passes = !admit(message->from).empty();
    } else if (own_message_.empty()) {
      // There is no message of our own to answer with: let the library discover the sender and
      // answer it.
      if (!multicast) verdict.passes = !take_held(message->from).empty();
    } else if (must_answer && !message->to) {
      verdict.answer = directed(own_message_, message->from);
      verdict.to = message->announced->metatraffic;
    }
  } else if (is_known && own_ && message->to == own_ && budget_.ready(now)) {
    budget_.take(1);
    verdict = {.passes = true, .first = take_held(message->from)};
  }
  return verdict;
}

void DiscoveryFilter::on_announced(Time now, const link::DdsParticipant& from,
                                   std::span<const std::byte> message,
                                   const link::Announcement& announcement, Duration lease,
                                   Verdict& verdict) {
  auto known = routers_.find(from);
  if (known == routers_.end()) {
    if (routers_.size() == kRoutersMax || message.size() > kAnnouncedMax) return;
    known = routers_.emplace(from, Router()).first;
  }
  Router& router = known->second;
  router.last_received = now;
  router.lease = lease;
  if (router.announcement == announcement) return;
  router.announcement = announcement;
  router.message.assign(message.begin(), message.end());
  verdict.announced = announcement;
}

void DiscoveryFilter::on_own(std::span<const std::byte> bytes) {
  if (own_ && !own_message_.empty()) return;
  const auto message = parse_rtps(bytes);
  if (!message) return;
  own_ = message->from;
  if (message->announced && bytes.size() <= kAnnouncedMax)
    own_message_.assign(bytes.begin(), bytes.end());
}

std::vector<std::byte> DiscoveryFilter::admit(const link::DdsParticipant& participant) {
  if (!routers_.contains(participant)) {
    wanted_.insert(participant);
    return {};
  }
  wanted_.erase(participant);
  return take_held(participant);
}

std::vector<std::byte> DiscoveryFilter::take_held(const link::DdsParticipant& participant) {
  const auto known = routers_.find(participant);
  if (known == routers_.end() || std::exchange(known->second.admitted, true)) return {};
  return std::exchange(known->second.message, {});
}

std::vector<link::DdsParticipant> DiscoveryFilter::expire(Time now) {
  std::vector<link::DdsParticipant> gone;
  for (const auto& [participant, router] : routers_) {
    if (now >= router.last_received + (router.admitted ? kLeasesAdmitted : 1) * router.lease)
      gone.push_back(participant);
  }
  for (const link::DdsParticipant& participant : gone) forget(participant);
  return gone;
}

}  // namespace tims::io

#include "tests/sim/toy_keys.h"

#include <algorithm>
#include <cstring>

#include "router/link/datagram.h"

namespace tims::sim {
namespace {

using link::ByteReader;
using link::ByteWriter;

enum class Record : std::uint8_t { kRandom = 1, kName = 2, kMessage = 3 };
// As long as the flights of TLS.
constexpr std::size_t kFlight = 700;
constexpr std::size_t kProofSize = 8;  // of a message
constexpr std::uint64_t kFromConnecting = 1;
constexpr std::uint64_t kFromAccepting = 2;

std::uint64_t hash(const core::SipKey& key, std::uint64_t tweak, std::span<const std::byte> bytes) {
  std::uint64_t sum = core::sip_hash(key, {tweak, bytes.size()});
  while (!bytes.empty()) {
    std::uint64_t word = 0;
    const std::size_t size = std::min(bytes.size(), sizeof word);
    std::memcpy(&word, bytes.data(), size);
    sum = core::sip_hash(key, {sum, word});
    bytes = bytes.subspan(size);
  }
  return sum;
}

core::SipKey next(const core::SipKey& key) {
  return {core::sip_hash(key, {1}), core::sip_hash(key, {2})};
}

void encrypt(const core::SipKey& key, std::uint64_t number, std::span<std::byte> text) {
  for (std::size_t at = 0; at < text.size(); at += 8) {
    const std::uint64_t stream = core::sip_hash(key, {number, at, 3});
    for (std::size_t i = 0; i < std::min<std::size_t>(8, text.size() - at); ++i)
      text[at + i] ^= static_cast<std::byte>(stream >> (8 * i) & 0xFF);
  }
}

std::array<std::byte, link::Sealer::kTagSize> tag_of(const core::SipKey& key, std::uint64_t number,
                                                     std::span<const std::byte> header,
                                                     std::span<const std::byte> text) {
  std::array<std::byte, link::Sealer::kTagSize> tag{};
  ByteWriter out(tag);
  const std::uint64_t sum = hash(key, number, text) ^ hash(key, ~number, header);
  out.put(sum, core::sip_hash(key, {sum, 4}));
  return tag;
}

void put_record(std::vector<std::byte>& to, Record kind, std::span<const std::byte> body) {
  std::array<std::byte, 3> head{};
  ByteWriter(head).put(static_cast<std::uint16_t>(body.size()), kind);
  to.insert(to.end(), head.begin(), head.end());
  to.insert(to.end(), body.begin(), body.end());
}

}  // namespace

link::Standing ToyList::standing(const link::PeerName& name) const {
  if (std::ranges::find(revoked, std::pair(name.system, name.id)) != revoked.end())
    return link::Standing::kRevoked;
  return name.issuer.empty() || std::to_integer<std::uint8_t>(name.issuer.front()) >= first_root
             ? link::Standing::kGood
             : link::Standing::kOldRoot;
}

std::vector<std::byte> ToyList::encode(std::uint64_t fleet) const {
  std::vector<std::byte> bytes(size);
  ByteWriter out(bytes);
  out.put(std::uint64_t{0}, number, first_root, static_cast<std::uint16_t>(revoked.size()));
  for (const auto& [system, id] : revoked) out.put(system, id);
  ByteWriter(bytes).put(hash({fleet, 5}, 0, std::span(bytes).subspan(8)));
  return bytes;
}

std::optional<ToyList> ToyList::open(std::span<const std::byte> bytes, std::uint64_t fleet) {
  ByteReader in(bytes);
  const auto signature = in.get<std::uint64_t>();
  ToyList list{.size = bytes.size()};
  std::uint16_t count = 0;
  in.get(list.number, list.first_root, count);
  if (!in.ok() || signature != hash({fleet, 5}, 0, bytes.subspan(8))) return std::nullopt;
  for (; count > 0; --count) {
    auto& [system, id] = list.revoked.emplace_back();
    in.get(system, id);
  }
  return in.ok() ? std::optional(std::move(list)) : std::nullopt;
}

ToySealer::ToySealer(const core::SipKey& sending, const core::SipKey& receiving)
    : sending_(sending), receiving_(receiving), next_(next(receiving)) {}

void ToySealer::seal(std::uint64_t number, std::span<const std::byte> header,
                     std::span<std::byte> text, std::span<std::byte, kTagSize> tag) {
  encrypt(sending_, number, text);
  std::ranges::copy(tag_of(sending_, number, header, text), tag.begin());
}

bool ToySealer::open(Phase phase, std::uint64_t number, std::span<const std::byte> header,
                     std::span<std::byte> text, std::span<const std::byte, kTagSize> tag) {
  const core::SipKey& key = phase == Phase::kFormer ? former_
                            : phase == Phase::kNext ? next_
                                                    : receiving_;
  if (!std::ranges::equal(tag_of(key, number, header, text), tag)) return false;
  encrypt(key, number, text);
  return true;
}

void ToySealer::next_sending_phase() { sending_ = next(sending_); }

void ToySealer::next_receiving_phase() {
  former_ = receiving_;
  receiving_ = next_;
  next_ = next(next_);
}

// --- the handshake: both sides send a random number, and their name with proof that they know the
// fleet's key and both numbers

core::SipKey ToyHandshaker::secret(const One& one, std::uint64_t purpose) const {
  const bool connects = one.side == Side::kConnects;
  const std::uint64_t first = connects ? one.ours : one.theirs;
  const std::uint64_t second = connects ? one.theirs : one.ours;
  const core::SipKey key{keys_.fleet, ~keys_.fleet};
  return {core::sip_hash(key, {first, second, one.binding, purpose, 1}),
          core::sip_hash(key, {first, second, one.binding, purpose, 2})};
}

void ToyHandshaker::begin(std::uint64_t handshake, Side side, std::span<const std::byte> binding) {
  One& one = all_[handshake];
  one.side = side;
  one.binding = hash({1, 2}, 0, binding);
  one.ours = core::next_random(random_);
  if (side != Side::kConnects) return;
  link::HandshakeProgress progress{.handshake = handshake};
  std::array<std::byte, 160> body{};
  ByteWriter(body).put(one.ours);
  put_record(progress.to_send, Record::kRandom, body);
  report_(std::move(progress));
}

void ToyHandshaker::put_name(const One& one, link::HandshakeProgress& progress) const {
  std::array<std::byte, kFlight> body{};
  ByteWriter out(body);
  const std::uint64_t purpose = one.side == Side::kConnects ? kFromConnecting : kFromAccepting;
  out.put(one.ours, keys_.name.role, keys_.name.system, keys_.name.id, keys_.root,
          static_cast<std::uint8_t>(keys_.name.name.size()));
  out.put_text(keys_.name.name);
  const std::uint64_t proof = hash(secret(one, purpose), 0, out.written());
  out.put(proof);
  put_record(progress.to_send, Record::kName, body);
}

bool ToyHandshaker::on_name(One& one, std::span<const std::byte> record,
                            link::HandshakeProgress& progress) {
  ByteReader in(record);
  const auto random = in.get<std::uint64_t>();
  const bool accepts = one.side == Side::kAccepts;
  if (accepts ? random != one.theirs : one.theirs != 0) return false;
  one.theirs = random;
  link::PeerName& peer = progress.verified.peer;
  in.get<std::uint8_t>();
  peer.role = static_cast<core::Role>(record[8]);
  in.get(peer.system, peer.id);
  peer.issuer = {static_cast<std::byte>(in.get<std::uint8_t>())};
  peer.name = in.text(in.get<std::uint8_t>());
  const auto signed_part = record.first(record.size() - in.rest().size());
  const std::uint64_t purpose = accepts ? kFromConnecting : kFromAccepting;
  if (in.get<std::uint64_t>() != hash(secret(one, purpose), 0, signed_part) || !in.ok())
    return false;
  if (!accepts) put_name(one, progress);
  one.verified = true;
  const core::SipKey connecting = secret(one, 3);
  const core::SipKey accepting = secret(one, 4);
  progress.verified.sealer = accepts ? std::make_unique<ToySealer>(accepting, connecting)
                                     : std::make_unique<ToySealer>(connecting, accepting);
  for (auto& message : std::exchange(one.waiting, {}))
    put_message(one, std::move(message), progress);
  return true;
}

std::uint64_t ToyHandshaker::proof(const One& one, bool of_connecting,
                                   std::span<const std::byte> message) const {
  return hash(secret(one, of_connecting ? 5 : 6), 0, message);
}

void ToyHandshaker::put_message(const One& one, std::vector<std::byte> message,
                                link::HandshakeProgress& progress) const {
  std::array<std::byte, kProofSize> bytes{};
  ByteWriter(bytes).put(proof(one, one.side == Side::kConnects, message));
  message.insert(message.end(), bytes.begin(), bytes.end());
  put_record(progress.to_send, Record::kMessage, message);
}

bool ToyHandshaker::on_record(One& one, std::span<const std::byte> record,
                              link::HandshakeProgress& progress) {
  const auto kind = static_cast<Record>(record[2]);
  const auto body = record.subspan(3);
  if (kind == Record::kRandom && one.side == Side::kAccepts && one.theirs == 0 &&
      body.size() >= 8) {
    one.theirs = ByteReader(body).get<std::uint64_t>();
    put_name(one, progress);
    return true;
  }
  if (kind == Record::kName && !one.verified && body.size() == kFlight)
    return on_name(one, body, progress);
  if (kind != Record::kMessage || !one.verified || body.size() < kProofSize) return false;
  const auto message = body.first(body.size() - kProofSize);
  if (ByteReader(body.last(kProofSize)).get<std::uint64_t>() !=
      proof(one, one.side == Side::kAccepts, message))
    return false;
  progress.messages.emplace_back(message.begin(), message.end());
  return true;
}

void ToyHandshaker::receive(std::uint64_t handshake, std::span<const std::byte> bytes) {
  const auto found = all_.find(handshake);
  if (found == all_.end()) return;
  One& one = found->second;
  one.in.insert(one.in.end(), bytes.begin(), bytes.end());
  link::HandshakeProgress progress{.handshake = handshake};
  while (one.in.size() >= 3) {
    const std::size_t size = 3 + std::size_t{ByteReader(one.in).get<std::uint16_t>()};
    if (one.in.size() < size) break;
    if (!on_record(one, std::span(one.in).first(size), progress)) {
      progress.failure = "unknown fleet";
      break;
    }
    one.in.erase(one.in.begin(), one.in.begin() + static_cast<std::ptrdiff_t>(size));
  }
  report_(std::move(progress));
}

void ToyHandshaker::send(std::uint64_t handshake, std::span<const std::byte> message) {
  const auto found = all_.find(handshake);
  if (found == all_.end()) return;
  std::vector<std::byte> bytes(message.begin(), message.end());
  if (keys_.alter) keys_.alter(bytes);
  if (!found->second.verified) {
    found->second.waiting.push_back(std::move(bytes));
    return;
  }
  link::HandshakeProgress progress{.handshake = handshake};
  put_message(found->second, std::move(bytes), progress);
  report_(std::move(progress));
}

}  // namespace tims::sim

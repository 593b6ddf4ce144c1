// Stand-ins for what seals links (router/link/seal.h), made of SipHash instead of TLS: on the
// virtual clock, determined by the seed, and quick. They keep off attackers that do not know the
// key of the fleet, as those of the simulation do not.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "router/core/random.h"
#include "router/link/seal.h"

namespace tims::sim {

// What a router of the simulation has in place of a folder of keys.
struct ToyKeys {
  std::uint64_t fleet = 0;  // the fleet's key
  link::PeerName name{};    // that its certificate states
  std::uint8_t root = 1;    // from which its certificate comes; a later one has a higher number
  // What it does to its WHO and WELCOME: a robot that was broken into says what it likes.
  std::function<void(std::vector<std::byte>& message)> alter{};
};

// A list of the fleet: its number, the first root that is believed, the routers whose certificates
// are revoked, and as many bytes as are to be carried, signed with the fleet's key.
struct ToyList {
  std::uint64_t number = 0;
  std::uint8_t first_root = 1;
  std::vector<std::pair<std::uint16_t, std::uint16_t>> revoked{};  // system, id
  std::size_t size = 200;

  [[nodiscard]] link::Standing standing(const link::PeerName& name) const;
  [[nodiscard]] std::vector<std::byte> encode(std::uint64_t fleet) const;
  // Nothing if it is not of this fleet.
  static std::optional<ToyList> open(std::span<const std::byte> bytes, std::uint64_t fleet);
};

class ToySealer final : public link::Sealer {
 public:
  ToySealer(const core::SipKey& sending, const core::SipKey& receiving);

  void seal(std::uint64_t number, std::span<const std::byte> header, std::span<std::byte> text,
            std::span<std::byte, kTagSize> tag) override;
  [[nodiscard]] bool open(Phase phase, std::uint64_t number, std::span<const std::byte> header,
                          std::span<std::byte> text,
                          std::span<const std::byte, kTagSize> tag) override;
  void next_sending_phase() override;
  void next_receiving_phase() override;
  [[nodiscard]] std::string_view suite() const override { return "toy"; }

 private:
  core::SipKey sending_;
  core::SipKey former_{};
  core::SipKey receiving_;
  core::SipKey next_;
};

class ToyHandshaker final : public link::Handshaker {
 public:
  // `report` is called for each progress, and passes it on later.
  using Report = std::function<void(link::HandshakeProgress&&)>;
  ToyHandshaker(const ToyKeys& keys, std::uint64_t seed, Report report)
      : keys_(keys), random_(seed), report_(std::move(report)) {}

  void begin(std::uint64_t handshake, Side side, std::span<const std::byte> binding) override;
  void receive(std::uint64_t handshake, std::span<const std::byte> bytes) override;
  void send(std::uint64_t handshake, std::span<const std::byte> message) override;
  void end(std::uint64_t handshake) override { all_.erase(handshake); }

  // The certificate that is shown from now on.
  void set_keys(const ToyKeys& keys) { keys_ = keys; }
  [[nodiscard]] std::size_t running() const { return all_.size(); }

 private:
  struct One {
    Side side{};
    std::uint64_t binding = 0;
    std::uint64_t ours = 0;    // random
    std::uint64_t theirs = 0;  // random
    bool verified = false;
    std::vector<std::byte> in{};                    // not yet a whole record
    std::vector<std::vector<std::byte>> waiting{};  // messages to be sent when it is verified
  };
  bool on_record(One& one, std::span<const std::byte> record, link::HandshakeProgress& progress);
  bool on_name(One& one, std::span<const std::byte> record, link::HandshakeProgress& progress);
  void put_name(const One& one, link::HandshakeProgress& progress) const;
  void put_message(const One& one, std::vector<std::byte> message,
                   link::HandshakeProgress& progress) const;
  [[nodiscard]] std::uint64_t proof(const One& one, bool of_connecting,
                                    std::span<const std::byte> message) const;
  [[nodiscard]] core::SipKey secret(const One& one, std::uint64_t purpose) const;

  ToyKeys keys_;
  std::uint64_t random_;
  Report report_;
  std::map<std::uint64_t, One> all_;
};

}  // namespace tims::sim

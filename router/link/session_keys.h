// The keys of a session. Each handshake brings a generation of them, and within a generation each
// direction changes its keys by itself, in phases. DATA names both.
//
// A session without keys is not sealed: every datagram opens, and nothing is added to any.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "router/link/frame.h"
#include "router/link/seal.h"
#include "tims/time.h"

namespace tims::link {

class SessionKeys {
 public:
  // A phase ends after so many packets (AES-GCM: RFC 9001, section 6.6) or this time.
  static constexpr std::uint64_t kPacketsMax = std::uint64_t{1} << 23;
  static constexpr Duration kPhaseMax = std::chrono::hours(1);
  // How long datagrams under former keys, which were sent before, may still arrive.
  static constexpr Duration kFormerFor = std::chrono::seconds(10);

  void clear() {
    for (Generation* keys : {&current_, &former_, &next_}) *keys = {};
    locked_ = false;
  }
  // Of a new session.
  void begin(Time now, std::unique_ptr<Sealer> sealer);
  // Of a running session. `confirmed`: the other side has them, so they are used at once; otherwise
  // from the first datagram on that opens with them.
  void renew(Time now, std::uint8_t generation, std::unique_ptr<Sealer> sealer, bool confirmed);
  // Of a session that another router has left to this one, without its keys: until the next
  // handshake nothing opens, and nothing must be sent.
  void lock(Time now, std::uint8_t generation);
  [[nodiscard]] bool are_locked() const { return locked_ && are_used(); }
  // The number of the generation that the next handshake brings.
  [[nodiscard]] std::uint8_t next_generation() const;

  [[nodiscard]] bool are_used() const { return current_.sealer != nullptr; }
  [[nodiscard]] std::size_t overhead() const { return are_used() ? Sealer::kTagSize : 0; }
  [[nodiscard]] std::string_view suite() const {
    return are_used() ? current_.sealer->suite() : std::string_view();
  }
  [[nodiscard]] std::uint8_t generation() const { return current_.number; }
  [[nodiscard]] std::uint8_t sending_phase() const { return current_.sending; }
  // When the keys in use came from a handshake.
  [[nodiscard]] Time since() const { return current_.since; }

  // Writes the header, and seals what stands between it and the room for the tag.
  void seal(Time now, std::uint64_t token, std::uint64_t packet, std::span<std::byte> datagram);
  enum class Verdict : std::uint8_t { kOpened, kForged, kOldKey };
  // Decrypts the frames in place; the tag is then no part of them any more.
  Verdict open(Time now, std::uint64_t packet, Data& data);

 private:
  struct Generation {
    std::uint8_t number = 0;
    std::unique_ptr<Sealer> sealer{};
    Time since{};
    std::uint8_t sending = 0;  // phase
    std::uint64_t sealed = 0;  // packets in this phase
    Time sends_since{};        // in this phase
    std::uint8_t receiving = 0;
    std::uint64_t first = 0;  // the first packet that opened in this phase
    Time former_until{};      // the phase before still opens
  };
  static Verdict open(Time now, std::uint64_t packet, Data& data, Generation& keys);
  void use_next(Time now);

  Generation current_;
  Generation former_;
  Generation next_;
  Time former_until_{};
  bool locked_ = false;
};

}  // namespace tims::link

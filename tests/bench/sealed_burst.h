// Bursts of datagrams sealed and opened in place with AES-128-GCM, nothing copied: the least that
// two relays with keys have to do. Each datagram gets a header with its number, and a tag, as those
// of a link.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <sys/uio.h>

#include "security/crypto/aead.h"

namespace tims::bench {

class SealedBurst {
 public:
  static constexpr std::size_t kHeader = 16;
  static constexpr std::size_t kOverhead = kHeader + security::kTagBytes;

  SealedBurst();

  // What is to be sent instead of the datagrams of this size in `burst`, of which the last one may
  // be shorter. The parts point into `burst` and into this object.
  std::span<iovec> seal(std::span<std::byte> burst, std::size_t size);
  // The same for sealed datagrams. Those that do not open are left out.
  std::span<iovec> open(std::span<std::byte> burst, std::size_t size);

 private:
  struct Frame {
    std::array<std::byte, kHeader> header{};
    std::array<std::byte, security::kTagBytes> tag{};
  };
  static constexpr std::size_t kDatagrams = 64;  // of one burst, as many as the kernel merges

  void add(std::span<std::byte> bytes) { parts_.push_back({bytes.data(), bytes.size()}); }

  security::Aead sealing_{security::Aead::Direction::kSeal};
  security::Aead opening_{security::Aead::Direction::kOpen};
  std::uint64_t number_ = 0;
  std::array<Frame, kDatagrams> frames_;
  std::vector<iovec> parts_;
};

}  // namespace tims::bench

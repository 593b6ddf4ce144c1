#include "tests/bench/sealed_burst.h"

#include <algorithm>

namespace tims::bench {
namespace {

security::Nonce nonce_of(std::span<const std::byte> header) {
  security::Nonce nonce{};
  std::ranges::copy(header.first(nonce.size()), nonce.begin());
  return nonce;
}

}  // namespace

SealedBurst::SealedBurst() {
  const std::array<std::byte, 16> key{};
  (void)sealing_.set_key(security::Suite::kAes128Gcm, key);
  (void)opening_.set_key(security::Suite::kAes128Gcm, key);
  parts_.reserve(3 * kDatagrams);
}

std::span<iovec> SealedBurst::seal(std::span<std::byte> burst, std::size_t size) {
  parts_.clear();
  for (Frame& frame : frames_) {
    if (burst.empty()) break;
    const auto text = burst.first(std::min(size, burst.size()));
    burst = burst.subspan(text.size());
    std::ranges::copy(std::as_bytes(std::span(&++number_, 1)), frame.header.begin());
    (void)sealing_.seal(nonce_of(frame.header), frame.header, text, frame.tag);
    add(frame.header);
    add(text);
    add(frame.tag);
  }
  return parts_;
}

std::span<iovec> SealedBurst::open(std::span<std::byte> burst, std::size_t size) {
  parts_.clear();
  while (burst.size() > kOverhead && parts_.size() < kDatagrams) {
    const auto datagram = burst.first(std::min(size, burst.size()));
    burst = burst.subspan(datagram.size());
    if (datagram.size() <= kOverhead) break;
    const auto header = datagram.first<kHeader>();
    const auto text = datagram.subspan(kHeader, datagram.size() - kOverhead);
    if (opening_.open(nonce_of(header), header, text, datagram.last<security::kTagBytes>()))
      add(text);
  }
  return parts_;
}

}  // namespace tims::bench

// The limit between two hosts: messages as a stream of bare datagrams, directly to the other end or
// to a relay. A lost datagram would invalidate the stream, so buffers are larger than windows.
// Small messages of a stream are collected, large ones are sent without copying, and received ones
// are read in place.
#pragma once

#include <cstring>
#include <vector>

#include "tests/bench/link.h"
#include "tests/bench/message.h"
#include "tests/bench/plan.h"
#include "tests/bench/udp.h"
#include "wire/header.h"

namespace tims::bench {

class UdpLink {
 public:
  // `datagram`: the size of its datagrams.
  static Result<UdpLink> open(const Plan& plan, std::size_t datagram);

  [[nodiscard]] bool needs_credit() const { return true; }
  bool send(std::span<const std::byte> payload);
  void flush();

  template <typename Deliver>
  void receive(Duration timeout, Deliver deliver) {
    flush();
    if (!read_some(timeout)) return;
    while (end_ - at_ >= kHeaderSize) {
      Header header;
      std::memcpy(&header, &in_[at_], sizeof header);
      if (end_ - at_ < header.length) break;
      deliver(std::span(&in_[at_ + kHeaderSize], header.length - kHeaderSize));
      at_ += header.length;
    }
    if (at_ == end_) at_ = end_ = 0;
  }

 private:
  static constexpr std::size_t kGather =
      62 << 10;  // together with one more small message it fills a burst
  // Both ends are on the same machine, so a Header can be read without conversion.
  static_assert(sizeof(Header) == kHeaderSize && offsetof(Header, length) == 12);

  UdpLink(const Plan& plan, std::size_t datagram, os::File socket);
  void append(const void* bytes, std::size_t size);
  bool read_some(Duration timeout);

  os::File socket_;
  std::size_t datagram_;
  Duration timeout_{};
  Header header_;  // of the messages
  std::size_t gather_;
  std::vector<std::byte> out_;
  std::size_t filled_ = 0;
  std::vector<std::byte> in_;
  std::size_t at_ = 0;
  std::size_t end_ = 0;
};

}  // namespace tims::bench

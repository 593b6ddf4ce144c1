// A client of the original protocol over TCP, as fast as one can be: small messages of a stream
// are gathered, large ones leave without being copied, and what comes is read in place. The same
// client talks to the router and to the bare relay, so that only what stands between differs.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "libtims/os/file.h"
#include "libtims/wire/header.h"
#include "tests/bench/link.h"
#include "tests/bench/message.h"
#include "tests/bench/plan.h"

namespace tims::bench {

class TcpLink {
 public:
  enum class Between { kRouter, kRelay };

  // Connects and registers its one mailbox.
  static Result<TcpLink> open(const Plan& plan, Between between);

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
      if (header.dest.raw() != 0)
        deliver(std::span(&in_[at_ + kHeaderSize], header.length - kHeaderSize));
      at_ += header.length;
    }
    if (at_ == end_) at_ = end_ = 0;
  }
  // A slow reader does not hold up a sender: the router would drop. The relay holds it up.
  [[nodiscard]] bool needs_credit() const { return between_ == Between::kRouter; }

 private:
  // Messages arrive in native order (the router rewrites headers): a Header can be read as is.
  static_assert(sizeof(Header) == kHeaderSize && offsetof(Header, length) == 12);

  TcpLink(const Plan& plan, Between between, os::File socket);
  Result<void> register_mailbox(Address address);
  void append(const void* bytes, std::size_t size);
  bool read_some(Duration timeout);

  os::File socket_;
  Between between_;
  Duration timeout_{};
  Header header_;  // of what is sent
  std::size_t gather_;
  std::vector<std::byte> out_;
  std::size_t filled_ = 0;
  std::vector<std::byte> in_;
  std::size_t at_ = 0;
  std::size_t end_ = 0;
};

}  // namespace tims::bench

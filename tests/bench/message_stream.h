// Messages of the original protocol through a socket, as fast as it can be done: small messages of
// a stream are gathered, large ones leave without being copied, and what comes is read in place.
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

class MessageStream {
 public:
  virtual ~MessageStream() = default;

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

 protected:
  // `gather`: of a stream, about so many bytes leave at once.
  MessageStream(const Plan& plan, os::File socket, std::size_t gather);
  MessageStream(MessageStream&&) = default;

  [[nodiscard]] const os::File& socket() const { return socket_; }
  [[nodiscard]] const Header& header() const { return header_; }
  virtual bool write(std::span<const std::byte> first, std::span<const std::byte> second) = 0;

 private:
  // Messages arrive in native order (the router rewrites headers): a Header can be read as is.
  static_assert(sizeof(Header) == kHeaderSize && offsetof(Header, length) == 12);

  void append(const void* bytes, std::size_t size);
  bool read_some(Duration timeout);

  os::File socket_;
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

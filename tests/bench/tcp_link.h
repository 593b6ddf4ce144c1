// A client of the original protocol over TCP. The same client talks to the router and to the bare
// relay, so that only what stands between differs.
#pragma once

#include "tests/bench/message_stream.h"

namespace tims::bench {

class TcpLink final : public MessageStream {
 public:
  enum class Between { kRouter, kRelay };

  // Connects and registers its one mailbox.
  static Result<TcpLink> open(const Plan& plan, Between between);

  // A slow reader does not hold up a sender: the router would drop. The relay holds it up.
  [[nodiscard]] bool needs_credit() const { return between_ == Between::kRouter; }

 private:
  static constexpr std::size_t kGather = 64 << 10;

  TcpLink(const Plan& plan, Between between, os::File socket)
      : MessageStream(plan, std::move(socket), kGather), between_(between) {}
  Result<void> register_mailbox();
  bool write(std::span<const std::byte> first, std::span<const std::byte> second) override;

  Between between_;
};

}  // namespace tims::bench

// What the processes of a measurement say to each other: the first bytes of every payload.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace tims::bench {

enum class Kind : std::uint32_t {
  kHello = 1,  // a sender looks for its receivers
  kReady,      // a receiver is there
  kData,       // what is measured
  kAck,        // a receiver has had everything up to seq: credit for the sender
  kEnd,        // no more data; seq counts what was sent
  kDone,       // a receiver has seen the end
};

struct Head {
  Kind kind = Kind::kHello;
  std::uint32_t who = 0;  // number of the receiver that speaks
  std::uint64_t seq = 0;
};

inline constexpr std::size_t kReplyBytes = 64;  // of ready, ack and done

// A payload that is sent again and again with another head.
class Payload {
 public:
  explicit Payload(std::size_t size) : bytes_(size < sizeof(Head) ? sizeof(Head) : size) {}

  std::span<const std::byte> with(const Head& head) {
    std::memcpy(bytes_.data(), &head, sizeof head);
    return bytes_;
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }

 private:
  std::vector<std::byte> bytes_;
};

inline Head head_of(std::span<const std::byte> payload) {
  Head head;
  std::memcpy(&head, payload.data(), sizeof head);
  return head;
}

}  // namespace tims::bench

// The protocol between the processes of a measurement, in the first bytes of every payload.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace tims::bench {

enum class Kind : std::uint32_t {
  kHello = 1,  // a sender searches its receivers
  kReady,      // a receiver is ready
  kData,       // measured data
  kAck,        // a receiver has received everything up to seq: credit for the sender
  kEnd,        // no more data; seq is the number of messages sent
  kDone,       // a receiver has received kEnd
};

struct Head {
  Kind kind = Kind::kHello;
  std::uint32_t receiver = 0;  // number of the sending receiver
  std::uint64_t seq = 0;
};

inline constexpr std::size_t kReplyBytes = 64;  // size of kReady, kAck and kDone

// A payload that is sent repeatedly with different heads.
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

// The limit on one host: a ring to all receivers, and one back from each.
#pragma once

#include <thread>
#include <vector>

#include "tests/bench/link.h"
#include "tests/bench/message.h"
#include "tests/bench/plan.h"
#include "tests/bench/shared_ring.h"

namespace tims::bench {

class RingLink {
 public:
  enum class Copy { kWhole, kHeadOnly };

  static Result<RingLink> open(const Plan& plan, Copy copy) {
    const std::size_t message_max = std::max(plan.payload, kReplyBytes);
    const bool alone = plan.subscribers == 1;
    SharedRing::Shape down{
        .message_max = message_max, .slots = slots_of(plan), .readers = plan.subscribers};
    if (plan.streaming()) {
      down.gather = std::clamp<std::uint64_t>(plan.window / 8, 1, 64);
      // Eight polling readers would compete for the CPUs.
      if (alone) down.spin = kStreamSpin;
    }
    RingLink link(plan, copy);
    for (std::uint32_t i = 0; i <= plan.subscribers; ++i) {
      const SharedRing::Shape up{.message_max = message_max,
                                 .slots = plan.streaming() ? 16 : slots_of(plan)};
      const std::string path = plan.folder + "/ring-" + std::to_string(plan.pair) + "-";
      auto ring = SharedRing::open(path + std::to_string(i), i == 0 ? down : up);
      if (!ring) return ring.error();
      link.rings_.push_back(std::move(*ring));
    }
    return link;
  }

  bool send(std::span<const std::byte> message) {
    const std::size_t copied = head_only_ ? sizeof(Head) : message.size();
    return (sender_ ? rings_[0] : rings_[1 + index_]).write(message, copied);
  }
  void flush() {
    if (sender_) rings_[0].publish();
  }
  template <typename Deliver>
  void receive(Duration timeout, Deliver deliver) {
    if (!sender_) return rings_[0].read(index_, timeout, deliver);
    if (rings_.size() == 2) return rings_[1].read(0, timeout, deliver);
    // Answers of several receivers arrive only before and after the measurement.
    for (std::size_t i = 1; i < rings_.size(); ++i) rings_[i].read(0, Duration::zero(), deliver);
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  [[nodiscard]] bool needs_credit() const { return false; }

 private:
  RingLink(const Plan& plan, Copy copy)
      : sender_(plan.sender()), head_only_(copy == Copy::kHeadOnly), index_(plan.index) {}

  bool sender_;
  bool head_only_;
  std::uint32_t index_;
  std::vector<SharedRing> rings_;  // first: to the receivers
};

}  // namespace tims::bench

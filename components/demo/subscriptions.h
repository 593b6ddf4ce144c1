// Who gets a component's data, and how often (specification, section 6: continuous data).
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tims/address.h"
#include "tims/message.h"
#include "tims/time.h"

namespace tims::demo {

class Subscriptions {
 public:
  static constexpr std::size_t kMax = 64;

  // GET_CONT_DATA: body is the period in ms (0: every sample) and the data mailbox. Returns the
  // period granted, a multiple of `sample_ms`; nothing for a bad body or when kMax are there.
  std::optional<std::uint32_t> add(const Header& request, std::span<const std::byte> body,
                                   std::uint32_t sample_ms);
  // STOP_CONT_DATA: body is the data mailbox.
  void remove(const Header& request, std::span<const std::byte> body);

  struct Subscriber {
    Address data_mailbox;
    std::uint8_t priority = 0;
    std::uint8_t seq_nr = 0;  // of the request: every sample carries it
    Duration period{};
    Time next{};
  };
  // Calls send(subscriber) for everyone whose next sample is due; a false return ends it.
  template <typename Send>
  void deliver(Time now, Send send) {
    std::erase_if(list_, [&](Subscriber& s) {
      if (now < s.next) return false;
      s.next = std::max((s.next == Time{} ? now : s.next) + s.period, now);
      return !send(s);
    });
  }
  [[nodiscard]] std::size_t size() const { return list_.size(); }

 private:
  std::vector<Subscriber> list_;
};

}  // namespace tims::demo

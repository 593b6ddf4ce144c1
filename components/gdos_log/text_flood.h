// Keeps one component that has much to say from filling the disk: each has its own limit, and
// details do not use up the room of errors. Pure.
//
// A sender has two token buckets (LineLimiter), one for prints, errors and warnings and one for the
// rest: a burst, then a steady rate. What does not fit is counted, and told from time to time.
// There is room for so many senders; when it is used up, those whose buckets are full are
// forgotten, as they are like new ones, and who finds no room shares one pair of buckets.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "base/rate_limiter.h"
#include "rack/proxies/gdos.h"

namespace rack::gdos_log {

class TextFlood {
 public:
  // Components that are told apart; what more of them say shares one limit.
  static constexpr std::size_t kSendersMax = 1024;
  // Above what a component of ours lets out by itself.
  static constexpr std::uint32_t kUrgentBurst = 400;
  static constexpr std::uint32_t kUrgentPerSecond = 50;
  static constexpr std::uint32_t kOtherBurst = 100;
  static constexpr std::uint32_t kOtherPerSecond = 20;
  // Between two words about the same flood.
  static constexpr tims::Duration kTellEach = std::chrono::seconds(1);

  // Whether a text may be kept.
  bool take(tims::Time now, tims::Address sender, gdos::Level level);

  struct Suppressed {
    tims::Address sender;
    std::uint32_t count;
  };
  // What has to be said by now of texts that were not kept. Cheap when there is nothing.
  std::vector<Suppressed> take_suppressed(tims::Time now);

 private:
  struct Sender {
    tims::base::LineLimiter urgent{kUrgentPerSecond, kUrgentBurst};  // print, error, warning
    tims::base::LineLimiter other{kOtherPerSecond, kOtherBurst};     // info, detail
  };
  Sender& find(tims::Time now, tims::Address sender);

  std::map<tims::Address, Sender> senders_;
  bool any_suppressed_ = false;
  tims::Time next_word_{};
};

}  // namespace rack::gdos_log

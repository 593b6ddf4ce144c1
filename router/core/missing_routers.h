// The routers that went with the link they were behind: who knows the fleet shall see that they are
// missing. Nothing is routed by it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

#include "router/core/text.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::core {

// When there are more, the oldest go.
inline constexpr std::size_t kMissingRoutersMax = 1024;
// Who has not come back in this time is not expected any more.
inline constexpr Duration kMissingRouterKept = std::chrono::minutes(10);

struct MissingRouter {
  std::uint64_t number = 0;  // counts up: the place in a list that is read in pages
  Address router{};
  Address behind{};  // the router at the other end of the link; may be this one itself
  Text<31> via{};    // and its name
  Time since{};
};

class MissingRouters {
 public:
  // In the order of time. It is none of them yet.
  void add(MissingRouter missing);
  // It is there again, behind whatever link.
  void found(Address router);
  template <typename Visit>  // (const MissingRouter&), the oldest first
  void for_each(Time now, Visit visit) const {
    for (const MissingRouter& missing : list_)
      if (now < missing.since + kMissingRouterKept) visit(missing);
  }

 private:
  std::deque<MissingRouter> list_;
  std::uint64_t numbers_ = 0;
};

}  // namespace tims::core

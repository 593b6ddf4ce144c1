// The routers that the DDS helper has announced: so many and no more, since it announces whoever
// claims to be one of the fleet, and a helper that was taken over whatever it likes. Pure.
#pragma once

#include <set>
#include <utility>

#include "router/link/fleet.h"
#include "router/link/transport.h"

namespace tims::io {

class AnnouncedRouters {
 public:
  static constexpr std::size_t kMax = link::Fleet::kRoutersMax;

  // Returns false when there are too many: it is to be ignored. One that is known stays.
  bool add(const link::NetAddress& dds) {
    if (known_.size() >= kMax && !known_.contains(dds)) return false;
    known_.insert(dds);
    return true;
  }
  void remove(const link::NetAddress& dds) { known_.erase(dds); }
  // All of them; afterwards there are none.
  std::set<link::NetAddress> take() { return std::exchange(known_, {}); }

 private:
  std::set<link::NetAddress> known_;
};

}  // namespace tims::io

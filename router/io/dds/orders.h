// What the loop wants of the engine's thread: a participant, with a writer for each router that is
// sent to. Both share it.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "router/io/dds/metatraffic.h"
#include "router/io/dds/user_traffic.h"
#include "router/link/announcement.h"
#include "tims/time.h"

namespace tims::io {

// A router that is sent to.
struct DdsPeer {
  explicit DdsPeer(const link::NetAddress& to) : address(to) {}

  const link::NetAddress address;
  std::atomic<bool> matched = false;  // its reader is there: what is written arrives
};

class DdsOrders {
 public:
  struct Wanted {
    std::uint64_t life = 0;  // another number: another participant
    link::Announcement self{};
    std::shared_ptr<UserTraffic> traffic{};
    std::shared_ptr<Metatraffic> metatraffic{};  // none: a server says who there is
    std::vector<std::shared_ptr<DdsPeer>> peers{};
    bool end = false;
  };

  // By the loop. `change` is a function of Wanted&.
  template <typename Change>
  void change(Change&& change) {
    {
      const std::lock_guard lock(mutex_);
      change(wanted_);
      changed_ = true;
    }
    change_.notify_one();
  }
  // False when the thread has not ended by then.
  bool wait_for_end(Duration limit);

  // By the thread: what is wanted, once that is something else than before.
  Wanted wait();
  void ended();

 private:
  std::mutex mutex_;
  std::condition_variable change_;
  std::condition_variable end_;
  Wanted wanted_{};
  bool changed_ = false;
  bool ended_ = false;
};

}  // namespace tims::io

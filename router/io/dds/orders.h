// What the loop wants of the engine's thread: a participant, and datagrams written. Both share it.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "router/io/dds/send_queue.h"
#include "router/link/announcement.h"
#include "tims/time.h"

namespace tims::io {

// A router that is sent to.
struct DdsPeer {
  explicit DdsPeer(const link::NetAddress& to) : address(to) {}

  const link::NetAddress address;
  SendQueue queue;
  std::atomic<bool> matched = false;  // its reader is there: what is written arrives
};

// Counted by the thread.
struct DdsWritten {
  std::atomic<std::uint64_t> samples = 0;
  std::atomic<std::uint64_t> bytes = 0;
  std::atomic<std::uint64_t> datagrams = 0;
  std::atomic<std::uint64_t> unmatched = 0;
};

class DdsOrders {
 public:
  struct Wanted {
    std::uint64_t life = 0;  // another number: another participant
    link::Announcement self{};
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
    stir();
  }
  // By anybody: there is something to write, or it has become possible.
  void stir() {
    {
      const std::lock_guard lock(mutex_);
      stirred_ = true;
    }
    wake_.notify_one();
  }
  // False when the thread has not ended by then.
  bool wait_for_end(Duration limit);

  // By the thread: until somebody stirs, or `until`. True when `wanted` is another one now.
  bool wait(Time until, Wanted& wanted);
  void ended();

  DdsWritten written{};

 private:
  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable end_;
  Wanted wanted_{};
  bool changed_ = false;
  bool stirred_ = false;
  bool ended_ = false;
};

}  // namespace tims::io

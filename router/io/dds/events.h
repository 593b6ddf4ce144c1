// Communication between the loop and the threads of the engine: events from the library's threads
// and the engine's own thread to the loop, which is woken by an eventfd; commands from the loop
// to the engine's thread. A command describes a wanted state, not a step: only the latest one is
// executed.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/rate_limiter.h"
#include "os/wakeup.h"
#include "router/link/datagram.h"
#include "tims/time.h"

namespace eprosima::fastdds::dds {
class DataReader;
}

namespace tims::io {

class DdsWriter;
class Metatraffic;
class UserTraffic;

// A router that we send to.
struct DdsPeer {
  explicit DdsPeer(const link::NetAddress& to) : address(to) {}

  const link::NetAddress address;
  std::atomic<bool> matched = false;  // its reader has been discovered: samples will arrive
};

// `generation` counts participants, so that events of an earlier one can be recognised.
class DdsEvents {
 public:
  struct Up {
    std::uint64_t generation = 0;
    link::NetAddress address{};
    std::vector<link::NetAddress> host{};  // addresses of this host that it announces
    // Owned by the loop until it wants another generation.
    eprosima::fastdds::dds::DataReader* reader = nullptr;
  };
  struct Failure {
    std::uint64_t generation = 0;
    std::string text{};
  };
  struct Router {
    std::uint64_t generation = 0;                      // of the participant that received it
    std::optional<link::Announcement> announcement{};  // empty: gone, or not one of our routers
  };
  struct WriterReady {
    std::uint64_t generation = 0;
    std::shared_ptr<DdsPeer> peer{};
    DdsWriter* writer = nullptr;  // used by the loop while it wants the peer and this generation
  };
  struct Line {
    bool error = false;
    std::string text{};
  };
  // All events since the last call; for each router only the latest.
  struct All {
    std::optional<Up> up{};
    std::optional<Failure> failure{};
    std::map<link::DdsParticipant, Router> routers{};
    std::vector<WriterReady> writers{};
    std::vector<Line> lines{};
  };

  static Result<std::shared_ptr<DdsEvents>> make();
  explicit DdsEvents(os::File wake_fd) : wake_fd_(std::move(wake_fd)) {}

  // Called by any thread.
  void post_up(Up up);
  void post_failure(Failure failure);
  void post_router(const link::DdsParticipant& participant, Router router);
  void post_writer(WriterReady ready);
  void post_line(Line line);  // limited when there are many
  // Samples have arrived, or a reader has appeared.
  void wake() { notify(); }

  // Called by the loop: readable when there are events.
  [[nodiscard]] int fd() const { return wake_fd_.get(); }
  All take();
  // Events posted from within `work` do not wake the loop, which checks afterwards anyway.
  template <typename Work>
  void without_notifying(Work work) {
    notified_ = true;
    work();
  }

 private:
  template <typename Change>
  void post(Change change);
  void notify();

  const os::File wake_fd_;
  std::atomic<bool> notified_ = false;  // and not read yet
  std::mutex mutex_;
  All all_{};

  base::LineLimiter lines_limiter_{1, 10};
};

// The wanted participant, with a writer for each router that we send to. Shared by the loop and
// the thread.
class DdsCommands {
 public:
  struct Wanted {
    std::uint64_t generation = 0;  // another number: another participant
    link::Announcement self{};
    std::shared_ptr<UserTraffic> traffic{};
    std::shared_ptr<Metatraffic> metatraffic{};  // none: a discovery server is used
    std::vector<std::shared_ptr<DdsPeer>> peers{};
    bool end = false;
  };

  // Called by the loop. `change` is a function of Wanted&.
  template <typename Change>
  void change(Change&& change) {
    {
      const std::lock_guard lock(mutex_);
      change(wanted_);
      changed_ = true;
    }
    change_.notify_one();
  }
  // Returns false when the thread has not ended in time.
  bool wait_for_end(Duration limit);

  // Called by the thread: waits until the wanted state changes, and returns it.
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

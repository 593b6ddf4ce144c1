// What the loop and the threads of the engine tell each other: events from the threads of the
// library and the engine's own to the loop, which an eventfd wakes; commands from the loop to the
// engine's thread. A command is a wish for a state, not for a step: of many, the thread carries out
// the last.
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

// A router that is sent to.
struct DdsPeer {
  explicit DdsPeer(const link::NetAddress& to) : address(to) {}

  const link::NetAddress address;
  std::atomic<bool> matched = false;  // its reader is there: what is written arrives
};

// `generation` counts participants: what an earlier one has left behind is told apart by it.
class DdsEvents {
 public:
  struct Up {
    std::uint64_t generation = 0;
    link::NetAddress address{};
    // The loop's until it wants another generation.
    eprosima::fastdds::dds::DataReader* reader = nullptr;
  };
  struct Failure {
    std::uint64_t generation = 0;
    std::string text{};
  };
  struct Router {
    std::uint64_t generation = 0;                      // of the participant that saw it
    std::optional<link::Announcement> announcement{};  // nothing: gone, or no router of ours
  };
  struct WriterReady {
    std::uint64_t generation = 0;
    std::shared_ptr<DdsPeer> peer{};
    DdsWriter* writer = nullptr;  // the loop's while it wants the peer, and this generation
  };
  struct Line {
    bool error = false;
    std::string text{};
  };
  // All since the last time; of each router the last word.
  struct All {
    std::optional<Up> up{};
    std::optional<Failure> failure{};
    std::map<link::DdsParticipant, Router> routers{};
    std::vector<WriterReady> writers{};
    std::vector<Line> lines{};
  };

  static Result<std::shared_ptr<DdsEvents>> make();
  explicit DdsEvents(os::File wake_fd) : wake_fd_(std::move(wake_fd)) {}

  // By any thread.
  void post_up(const Up& up);
  void post_failure(Failure failure);
  void post_router(const link::DdsParticipant& participant, Router router);
  void post_writer(WriterReady ready);
  void post_line(Line line);  // held back when there are many
  // There are samples, or a reader to write to.
  void wake() { notify(); }

  // By the loop: readable when there is something.
  [[nodiscard]] int fd() const { return wake_fd_.get(); }
  All take();
  // What is posted from within `work` wakes nobody: the loop looks by itself afterwards.
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
  std::atomic<bool> notified_ = false;  // and not heard yet
  std::mutex mutex_;
  All all_{};

  base::LineLimiter lines_limiter_{1, 10};
};

// A participant, with a writer for each router that is sent to. The loop and the thread share it.
class DdsCommands {
 public:
  struct Wanted {
    std::uint64_t generation = 0;  // another number: another participant
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

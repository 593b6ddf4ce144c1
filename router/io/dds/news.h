// What the threads of the library and the engine's own tell the loop.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "os/event_fd.h"
#include "router/link/announcement.h"
#include "tims/time.h"

namespace eprosima::fastdds::dds {
class DataReader;
}

namespace tims::io {

struct DdsPeer;
class DdsWriter;

class DdsNews {
 public:
  struct Up {
    std::uint64_t life = 0;
    link::NetAddress address{};
    eprosima::fastdds::dds::DataReader* reader =
        nullptr;  // of the loop until it wants another life
  };
  struct Failure {
    std::uint64_t life = 0;
    std::string text{};
  };
  struct Router {
    std::uint64_t life = 0;                            // of the participant that saw it
    std::optional<link::Announcement> announcement{};  // nothing: gone, or no router of ours
  };
  struct Opened {
    std::uint64_t life = 0;
    std::shared_ptr<DdsPeer> peer{};
    DdsWriter* writer = nullptr;  // of the loop as long as it wants the peer, and no other life
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
    std::vector<Opened> opened{};
    std::vector<Line> lines{};
  };

  static Result<std::shared_ptr<DdsNews>> make();
  explicit DdsNews(os::File bell) : bell_(std::move(bell)) {}

  // By any thread.
  void is_up(const Up& up);
  void has_failed(Failure failure);
  void has_seen(const link::DdsParticipant& participant, Router router);
  void has_opened(Opened opened);
  void has_said(Line line);  // held back when there are many
  // There are samples, or a reader to write to.
  void has_moved() { ring(); }

  // By the loop: readable when there is something.
  [[nodiscard]] int fd() const { return bell_.get(); }
  All take();
  // What is told from within `work` is not rung for: the loop looks by itself afterwards.
  template <typename Work>
  void quietly(Work work) {
    rung_ = true;
    work();
  }

 private:
  void ring();
  bool may_pass(Time now);

  const os::File bell_;
  std::atomic<bool> rung_ = false;  // and not heard yet
  std::mutex mutex_;
  All all_{};

  Time lines_since_{};
  unsigned lines_passed_ = 0;
  unsigned lines_held_back_ = 0;
};

}  // namespace tims::io

// Executes the long commands of a component one after the other, in a thread of its own, which is
// started by the first of them.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "rack/thread.h"
#include "tims/message.h"
#include "tims/result.h"

namespace rack {

class Worker {
 public:
  using Work = std::function<void()>;

  // Commands that wait for the one in progress.
  static constexpr std::size_t kWaitingMax = 8;

  // name: of the thread.
  explicit Worker(std::string name) : name_(std::move(name)) {}
  ~Worker() { (void)stop(); }

  // kInvalidArgument: kWaitingMax commands are waiting, or it has been stopped.
  tims::Result<void> add(const tims::Header& request, Work work);
  // Waits for the command in progress. Returns the requests whose turn has not come.
  std::vector<tims::Header> stop();

 private:
  struct Command {
    tims::Header request{};
    Work work{};
  };

  void run();
  // Waits for it; nothing: the worker stops.
  std::optional<Work> next();

  std::string name_;
  std::mutex mutex_;  // protects the members below
  std::condition_variable changed_;
  std::deque<Command> waiting_;
  bool is_stopped_ = false;
  std::optional<Thread> thread_;
};

}  // namespace rack

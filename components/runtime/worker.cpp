#include "components/runtime/worker.h"

namespace rack {

tims::Result<void> Worker::add(const tims::Header& request, Work work) {
  const auto refused = [](std::string why) {
    return tims::Error(tims::Errc::kInvalidArgument, std::move(why));
  };
  {
    const std::lock_guard lock(mutex_);
    if (is_stopped_) return refused("the component is stopping");
    if (waiting_.size() == kWaitingMax)
      return refused(std::to_string(kWaitingMax) +
                     " commands are waiting already; try again later");
    if (!thread_) {
      if (auto started = thread_.emplace().start({.name = name_}, [this] { run(); }); !started) {
        thread_.reset();
        return started;
      }
    }
    waiting_.push_back({request, std::move(work)});
  }
  changed_.notify_one();
  return {};
}

std::vector<tims::Header> Worker::stop() {
  std::deque<Command> given_up;  // destroyed without the mutex, as in run()
  {
    const std::lock_guard lock(mutex_);
    is_stopped_ = true;
    given_up.swap(waiting_);
  }
  changed_.notify_one();
  thread_.reset();
  std::vector<tims::Header> left;
  left.reserve(given_up.size());
  for (const Command& command : given_up) left.push_back(command.request);
  return left;
}

std::optional<Worker::Work> Worker::next() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return is_stopped_ || !waiting_.empty(); });
  if (is_stopped_) return std::nullopt;
  Work work = std::move(waiting_.front().work);
  waiting_.pop_front();
  return work;
}

// A work is destroyed without the mutex: what it holds may wait, as an object of Python does for
// the interpreter's lock, whose holder may wait in add().
void Worker::run() {
  while (const auto work = next()) (*work)();
}

}  // namespace rack

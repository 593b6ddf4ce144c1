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
  std::vector<tims::Header> left;
  {
    const std::lock_guard lock(mutex_);
    is_stopped_ = true;
    for (const Command& command : waiting_) left.push_back(command.request);
    waiting_.clear();
  }
  changed_.notify_one();
  thread_.reset();
  return left;
}

void Worker::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return is_stopped_ || !waiting_.empty(); });
    if (is_stopped_) return;
    const Work work = std::move(waiting_.front().work);
    waiting_.pop_front();
    lock.unlock();
    work();
    lock.lock();
  }
}

}  // namespace rack

// A descriptor in the loop's care: the owner is called as long as it is ready.
#pragma once

#include <cstdint>
#include <functional>

#include "router/io/loop.h"

namespace tims::io {

// What a descriptor is ready for; for both when it is broken.
struct Ready {
  bool to_read = false;
  bool to_write = false;
};

enum class Interest : std::uint32_t {
  kNothing = 0,
  kReading = EPOLLIN,
  kWriting = EPOLLOUT,
  kBoth = EPOLLIN | EPOLLOUT,
  // Once whenever it becomes ready for anything, not as long as it is.
  kChanges = EPOLLIN | EPOLLOUT | EPOLLRDHUP | EPOLLET,
};

class Watch {
 public:
  // `fd` stays open as long as this lives. The owner may destroy the watch when it is called.
  Watch(Loop& loop, int fd, std::function<void(Ready)> on_ready,
        Interest interest = Interest::kReading);
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;
  ~Watch();

  void set(Interest interest);

 private:
  friend Loop;
  Loop& loop_;
  const int fd_;
  std::function<void(Ready)> on_ready_;
  Interest interest_ = Interest::kNothing;
};

}  // namespace tims::io

// The service manager that started a program: systemd or `timsctl up`. It receives status datagrams
// at $NOTIFY_SOCKET as sd_notify(3) describes.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "os/file.h"
#include "tims/time.h"

namespace tims::os {

// The queue of such a socket is short (net.unix.max_dgram_qlen, usually 10), and many programs of a
// robot report at once when they start. What finds no room is kept and sent later. Safe for use by
// several threads.
class ServiceManager {
 public:
  // Empty path: there is no service manager, and reports are discarded. A name that begins with @
  // is abstract.
  explicit ServiceManager(std::string path);

  static ServiceManager of_environment();

  [[nodiscard]] bool listens() const { return !path_.empty(); }
  // Sends "VARIABLE=value", for example READY=1. Never waits: without room, the newest value of
  // each variable is kept. Returns false if anything is kept.
  bool report(std::string_view variable, std::string_view value);
  // Sends what is kept, as far as there is room. Returns false if anything is left: call it again
  // after kFlushPause.
  bool flush();
  static constexpr Duration kFlushPause = std::chrono::milliseconds(20);

 private:
  bool flush_locked();
  [[nodiscard]] bool send(const std::string& text) const;

  std::string path_;
  File socket_;
  std::mutex mutex_;
  std::map<std::string, std::string, std::less<>> kept_;  // protected by mutex_
};

}  // namespace tims::os

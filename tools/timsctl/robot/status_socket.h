// Where the programs of a robot say how they are, as services do to systemd (sd_notify(3)).
#pragma once

#include <optional>
#include <string>

#include <sys/types.h>

#include "os/file.h"

namespace timsctl::robot {

class StatusSocket {
 public:
  // A socket in the file system, for this user only. Throws Failure.
  explicit StatusSocket(std::string path);
  ~StatusSocket();
  StatusSocket(const StatusSocket&) = delete;
  StatusSocket& operator=(const StatusSocket&) = delete;

  [[nodiscard]] int descriptor() const { return socket_.get(); }
  struct Said {
    pid_t pid = 0;  // the system's word, not the sender's
    std::string text;
  };
  // What waits to be read, one by one.
  std::optional<Said> take();

 private:
  std::string path_;
  tims::os::File socket_;
};

// "READY=1\nSTATUS=on": what stands behind STATUS=; nothing when nothing does.
std::optional<std::string> status_in(std::string_view text);
bool says_ready(std::string_view text);
// A parameter of a component that was set while it ran: "vxMax=900".
std::optional<std::string> parameter_in(std::string_view text);

}  // namespace timsctl::robot

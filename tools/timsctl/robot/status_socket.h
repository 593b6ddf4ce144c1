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
std::optional<std::string> address_in(std::string_view text);  // of a component: "0x01110000"
// Of a component: a parameter that was set while it ran ("X_TIMS_PARAMETER=vxMax=900"), and what it
// goes on with after a crash ("X_TIMS_STATE=initPosX=120"; without a value: no more).
struct Told {
  std::string name;
  std::string value;
};
inline constexpr std::string_view kParameterTold = "X_TIMS_PARAMETER=";
inline constexpr std::string_view kStateTold = "X_TIMS_STATE=";
std::optional<Told> told_in(std::string_view text, std::string_view what);

}  // namespace timsctl::robot

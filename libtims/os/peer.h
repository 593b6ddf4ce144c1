// Who is at the other end of a socket of this host, as the kernel knows it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "os/file.h"

namespace tims::os {

// A program at a Unix socket, as it was when it connected.
struct LocalPeer {
  pid_t pid = 0;
  uid_t uid = static_cast<uid_t>(-1);  // nobody that exists
  gid_t gid = static_cast<gid_t>(-1);
  std::vector<gid_t> groups;  // the other ones
  std::string unit;           // systemd unit: "laser.service"; empty: none, or not certain
  std::string label;          // of AppArmor or SELinux; empty: none
};
// Call it right after the connection was accepted. The number of a process that has ended may be
// another one's by now: its unit is never the peer's. Kernels before 6.5 cannot name the process
// that connected; with them, one that was started before the connection was accepted is taken for
// it. `proc`: where the kernel tells about processes.
std::optional<LocalPeer> local_peer(int socket, const std::string& proc = "/proc");

// The unit of the process `pid`; empty if it has none, or has ended as `process`, a pidfd, tells.
std::string unit_of(const File& process, pid_t pid, const std::string& proc);
// Whether it began to run by this time after boot; `proc` as above.
bool has_started_by(double since_boot_s, pid_t pid, const std::string& proc);

// The user that owns the other end of a TCP connection within this host; empty: unknown, or the
// other end is elsewhere.
std::optional<uid_t> loopback_peer_uid(int socket);

// The unit in the text of /proc/PID/cgroup: of "0::/system.slice/laser.service/x" laser.service.
std::string unit_of_cgroup(const std::string& text);

}  // namespace tims::os

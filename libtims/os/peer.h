// Who is at the other end of a socket of this host, as the kernel knows it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

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
// Call it right after the connection was accepted: the unit is read from the process with the
// peer's number, which must not have been started after that.
std::optional<LocalPeer> local_peer(int socket);

// The user that owns the other end of a TCP connection within this host; empty: unknown, or the
// other end is elsewhere.
std::optional<uid_t> loopback_peer_uid(int socket);

// The unit in the text of /proc/PID/cgroup: of "0::/system.slice/laser.service/x" laser.service.
std::string unit_of_cgroup(const std::string& text);

}  // namespace tims::os

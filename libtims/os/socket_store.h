// Sockets that the service manager keeps while a program is restarted, or has opened for it:
// sd_listen_fds(3), and FDSTORE=1 of sd_notify(3). Who connects meanwhile waits and is not refused,
// and datagrams wait in the socket's buffer. Likewise memory, in which the program leaves its
// state.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <sys/socket.h>

#include "os/file.h"

namespace tims::os {

class ServiceManager;

class SocketStore {
 public:
  struct Inherited {
    std::vector<File> sockets{};
    std::map<std::string, File> memory{};  // by name; of several with one name, the last
  };
  // `manager` must outlive this object.
  SocketStore(ServiceManager& manager, Inherited inherited);
  // What $LISTEN_FDS has, if it is for this process. Removes the variables from the environment:
  // it is not for programs that this one starts.
  static Inherited inherited();

  // The inherited socket of this type (SOCK_STREAM, ...) that is bound to this address; empty:
  // there is none. Of several, one that a unit for sockets has opened is taken.
  File take(int type, const sockaddr& address);
  // The one that carries records (SOCK_SEQPACKET) and whose file is at `path`.
  File take_unix(const std::string& path);
  // For the next run of this program. Returns whether there is a manager that is able to keep it.
  bool keep(int socket);
  // Memory that the former run has left under this name, once: the manager keeps it no longer.
  // Empty: there is none, or it cannot be taken away from the manager, from which another run would
  // get it again.
  File take_memory(const std::string& name);
  bool keep_memory(const std::string& name, int memfd);
  // Closes what was inherited and nobody has taken, for example because the configuration has
  // changed. Returns the names.
  std::vector<std::string> forget_rest();

 private:
  ServiceManager& manager_;
  Inherited inherited_;
};

}  // namespace tims::os

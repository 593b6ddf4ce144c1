// Sockets that the service manager keeps while a program is restarted, or has opened for it:
// sd_listen_fds(3), and FDSTORE=1 of sd_notify(3). Who connects meanwhile waits and is not refused,
// and datagrams wait in the socket's buffer.
#pragma once

#include <string>
#include <vector>

#include <sys/socket.h>

#include "os/file.h"

namespace tims::os {

class ServiceManager;

class SocketStore {
 public:
  // `manager` must outlive this object.
  SocketStore(ServiceManager& manager, std::vector<File> inherited);
  // The sockets of $LISTEN_FDS, if they are for this process. Removes the variables from the
  // environment: the sockets are not for programs that this one starts.
  static std::vector<File> inherited();

  // The inherited socket of this type (SOCK_STREAM, ...) that is bound to this address; empty:
  // there is none.
  File take(int type, const sockaddr& address);
  // The one that carries records (SOCK_SEQPACKET) and whose file is at `path`.
  File take_unix(const std::string& path);
  // For the next run of this program. Returns whether there is a manager that is able to keep it.
  bool keep(int socket);
  // Closes inherited sockets that nobody has taken, for example because the configuration has
  // changed. Returns their names.
  std::vector<std::string> forget_rest();

 private:
  ServiceManager& manager_;
  std::vector<File> inherited_;
};

}  // namespace tims::os

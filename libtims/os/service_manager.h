// The service manager that started a program: `timsctl up`, or systemd. It receives the status of
// the program as sd_notify(3) describes.
//
// `timsctl up` passes each program one end of a connection, as $TIMS_SUPERVISOR. What was written
// there arrives even if the program crashes immediately afterwards. Other service managers have a
// socket for datagrams at $NOTIFY_SOCKET.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "os/file.h"
#include "tims/time.h"

namespace tims::os {

// A connection has room for some hundred reports. The queue of a datagram socket is short
// (net.unix.max_dgram_qlen, usually 10). What finds no room is kept and sent later. Safe for use by
// several threads.
class ServiceManager {
 public:
  // By datagrams. Empty path: there is no service manager, and reports are discarded. A name that
  // begins with @ is abstract.
  explicit ServiceManager(std::string path);
  // By a connection that keeps records apart (SOCK_SEQPACKET).
  explicit ServiceManager(File connection);

  // Removes the connection from the environment: it belongs to this object, not to programs that
  // this one starts.
  static ServiceManager of_environment();
  static constexpr const char* kConnectionVariable = "TIMS_SUPERVISOR";
  // The value of that variable: the number of the descriptor and its inode. A program that did not
  // inherit it may have another descriptor of the same number.
  static std::string connection_text(int descriptor);

  [[nodiscard]] bool listens() const { return static_cast<bool>(socket_); }
  // Sends "VARIABLE=value", for example READY=1. Never waits: without room, the newest value of
  // each variable is kept. Returns false if anything is kept.
  bool report(std::string_view variable, std::string_view value);
  // Waits for room, at most for this time. Returns false if anything is kept.
  bool report(std::string_view variable, std::string_view value, Duration patience);
  // Gives it a socket to keep while this program is restarted (FDSTORE=1), or lets it forget the
  // sockets of this name. False: it does not keep any, or is too busy. Waits for room, at most
  // 0.5 s. Names have at most 255 printable characters and no colon.
  bool keep(std::string_view name, int socket);
  bool forget(std::string_view name);
  // Sends what is kept, as far as there is room. Returns false if anything is left: call it again
  // after kFlushPause.
  bool flush();
  static constexpr Duration kFlushPause = std::chrono::milliseconds(20);

 private:
  bool flush_locked();
  bool send_about_sockets(const std::string& text, int socket) const;
  // `socket`: goes with the text; -1: none.
  [[nodiscard]] bool send(const std::string& text, int socket = -1) const;

  std::string path_;  // empty: a connection
  File socket_;
  std::mutex mutex_;
  std::map<std::string, std::string, std::less<>> kept_;  // protected by mutex_
};

}  // namespace tims::os

// Base of servers that a test needs: a thread that serves one TCP client after the other. It ends,
// with its connection, when the object does; the next one may have the same port.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <thread>

#include "os/file.h"

namespace tims::test {

class OneClientServer {
 public:
  explicit OneClientServer(std::uint16_t port);  // 0: any
  virtual ~OneClientServer();

  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] std::uint32_t clients() const { return clients_; }

 protected:
  // For the constructor and the destructor of the derived class.
  void start();
  void stop();
  // Returns when the client has gone or ends() is true.
  virtual void serve(int client) = 0;

  [[nodiscard]] bool ends() const { return ends_; }
  // The next bytes of the client; empty: none for some milliseconds. Throws if it is gone.
  [[nodiscard]] std::string receive(int client) const;
  // Throws if the client is gone or the test ends.
  void send(int client, std::string_view bytes) const;
  struct Gone {};

 private:
  void serve_all();

  os::File listener_;
  std::uint16_t port_ = 0;
  std::atomic<bool> ends_{false};
  std::atomic<std::uint32_t> clients_{0};
  std::thread thread_;
};

}  // namespace tims::test

// A TCP connection of which the test controls every byte. Calls wait, with a deadline.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "os/file.h"

namespace tims::test {

class ByteSocket {
 public:
  explicit ByteSocket(std::string_view endpoint);  // not connected: closed() says so

  // All of it; false when the other side has closed.
  bool send(std::string_view bytes);
  // As much as the system takes now.
  std::size_t send_some(std::string_view bytes);
  void shut_down_sending();
  void close();
  // Before anything has come: how much the system takes for this side.
  void set_receive_buffer(int bytes);

  // Exactly so many bytes, or everything up to and with `end`; less once the other side has closed.
  std::string take(std::size_t size);
  std::string take_until(std::string_view end);
  // Everything until the other side closes.
  std::string take_rest();
  // Whether something is there to be taken, without waiting.
  bool has_input();

  [[nodiscard]] bool closed() const { return closed_; }

 private:
  bool receive();

  os::File socket_;
  std::string received_;
  bool closed_ = false;
};

}  // namespace tims::test

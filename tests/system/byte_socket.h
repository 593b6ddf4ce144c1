// A TCP connection on which the test controls every byte. Calls block until a deadline.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "os/file.h"

namespace tims::test {

class ByteSocket {
 public:
  explicit ByteSocket(std::string_view endpoint);  // if it fails, closed() is true

  // Sends all bytes; false when the other side has closed.
  bool send(std::string_view bytes);
  // Sends as much as the system accepts now.
  std::size_t send_some(std::string_view bytes);
  void shut_down_sending();
  void close();
  // Sets the size of the system's receive buffer; call it before anything has arrived.
  void set_receive_buffer(int bytes);

  // Exactly so many bytes, or everything up to and including `end`; less if the other side closes.
  std::string take(std::size_t size);
  std::string take_until(std::string_view end);
  // Everything until the other side closes.
  std::string take_rest();
  // Whether bytes are available, without waiting.
  bool has_input();

  [[nodiscard]] bool closed() const { return closed_; }

 private:
  bool receive();

  os::File socket_;
  std::string received_;
  bool closed_ = false;
};

}  // namespace tims::test

// One WebSocket, from the handshake to the end: whole binary messages come in, frames go out.
//
// Behind a plain interface, because Boost.Beast's WebSocket costs a quarter of a minute of compile
// time and 600 MB of memory: websocket_session.cpp is the only file that includes it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "os/file.h"
#include "router/core/statistics.h"
#include "router/io/http/guest_socket.h"
#include "router/io/http/http_message.h"
#include "tims/time.h"

namespace tims::io {

// Close codes of RFC 6455, section 7.4.1, and of its registry.
enum class WebSocketClose : std::uint16_t {
  kGoingAway = 1001,
  kUnsupportedData = 1003,
  kBadData = 1007,
  kPolicy = 1008,
  kTryAgainLater = 1013,
};

class WebSocketSession {
 public:
  // What happens to a session. Comes from the event loop, never from within a call to the session.
  class Listener {
   public:
    virtual void on_open() = 0;  // the handshake is done: first of all calls
    // The bytes may be written to, and are used until the call returns.
    virtual void on_message(std::span<std::byte> message) = 0;
    // A part of a message came; so many bytes of it are here.
    virtual void on_part(std::size_t bytes) = 0;
    virtual void on_text() = 0;     // a text message came; what is in it is not handed out
    virtual void on_written() = 0;  // the frame is in the socket
    // Last of all calls. `unfinished`: bytes of a message that did not come to its end.
    virtual void on_end(core::CloseReason reason, std::size_t unfinished) = 0;

   protected:
    ~Listener() = default;
  };

  struct Settings {
    std::uint32_t message_max = 0;
    // How often the other side is asked whether it lives, with a WebSocket ping. One that has not
    // answered when the next is due, nor sent or read anything else, is given up.
    Duration ping_interval{};
    Duration handshake_timeout = std::chrono::seconds(10);
    Duration close_timeout = std::chrono::seconds(5);
  };

  // Answers `request`, the upgrade. The listener must stay until on_end() or drop().
  static std::shared_ptr<WebSocketSession> start(AsioGuest& guest, os::File socket,
                                                 const HttpRequest& request,
                                                 const Settings& settings, Listener& listener);
  virtual ~WebSocketSession() = default;

  virtual void set_ping_interval(Duration interval) = 0;

  // One frame at a time: the next one after on_written(), until when the bytes must stay.
  // `pieces`: kFramePiecesMax at most.
  virtual void write(std::span<const std::span<const std::byte>> pieces, bool last) = 0;

  // Says why, behind the frame that is being written, and ends; on_end() tells when. What still
  // comes in is thrown away.
  virtual void close(WebSocketClose code, std::string reason) = 0;
  // Ends at once and silently: no more calls to the listener, no more looks at bytes.
  virtual void drop() = 0;
};

}  // namespace tims::io

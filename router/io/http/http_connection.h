// One connection to the HTTP port, until it closes or becomes a WebSocket: reads a request, writes
// the answer, and so on.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "os/file.h"
#include "router/io/http/http_reader.h"
#include "router/io/http/http_response.h"
#include "router/io/watch.h"
#include "tims/time.h"

namespace tims::io {

struct HttpTimeouts {
  Duration request = std::chrono::seconds(10);  // to begin one; and to end one that has begun
  Duration idle = std::chrono::seconds(60);     // to begin a further one
  Duration answer = std::chrono::seconds(10);   // to take all of an answer
  Duration goodbye = std::chrono::seconds(2);   // to close behind the last answer
};

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  class Owner {
   public:
    virtual HttpResponse answer(const HttpRequest& request) = 0;
    virtual std::optional<HttpResponse> websocket_refusal(const HttpRequest& request) = 0;
    [[nodiscard]] virtual bool keeps_connections() const = 0;
    // It goes on as a WebSocket: take_socket(), then forget it.
    virtual void upgrade(HttpConnection& connection) = 0;
    // It is over: forget it.
    virtual void done(HttpConnection& connection) = 0;
    // At the end of each turn that began with this connection, which may be forgotten by now.
    virtual void end_turn(Time began, const HttpConnection& connection) = 0;

   protected:
    ~Owner() = default;
  };

  HttpConnection(Loop& loop, os::File socket, std::string peer, const HttpTimeouts& timeouts,
                 Owner& owner);

  void start(Time now);

  // When the other side has used up its time: then forget it.
  [[nodiscard]] Time deadline() const { return deadline_; }
  [[nodiscard]] bool is_writing() const { return state_ == State::kWriting; }

  os::File take_socket();
  [[nodiscard]] const HttpRequest& request() const { return reader_.request(); }
  [[nodiscard]] const std::string& peer() const { return peer_; }

 private:
  enum class State {
    kReading,
    kServing,  // there may be a further request in what was read
    kWriting,
    kGoodbye,  // all is written; what still comes is thrown away
    kDone,
  };

  void schedule();
  void take_turn_later();
  void take_turn();
  void read(Time now);
  void serve(Time now);
  void serve_request(Time now);
  void answer(Time now, const HttpResponse& response, HttpFraming framing);
  void write(Time now);
  void after_answer(Time now);
  void read_goodbye();
  void finish();

  Loop& loop_;
  os::File socket_;
  std::optional<Watch> watch_;
  const std::string peer_;
  const HttpTimeouts timeouts_;
  Owner& owner_;
  HttpReader reader_;
  State state_ = State::kReading;
  std::string output_;
  std::size_t written_ = 0;   // of output_
  bool last_answer_ = false;  // the connection closes behind what is in output_
  Time deadline_ = kNever;
};

}  // namespace tims::io

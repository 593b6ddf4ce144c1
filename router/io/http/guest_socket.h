// The basis of Boost.Beast's WebSocket: an io_context and a socket that run in the router's loop.
// A socket must be registered with one epoll instance only. With Asio's own epoll instance as a
// second one, the first to wake may poll the other before that one has seen the event; the event
// is then lost.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include <boost/asio/any_completion_handler.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/system/error_code.hpp>
#include <sys/uio.h>

#include "os/file.h"
#include "router/io/loop.h"

namespace tims::io {

// An io_context with neither a thread nor a wait of its own: the router's loop runs it when work
// was posted to it and when a GuestSocket has completed an operation. It has no timers, which
// would need more than that.
class AsioGuest {
 public:
  explicit AsioGuest(Loop& loop) : loop_(loop) {}
  AsioGuest(const AsioGuest&) = delete;
  AsioGuest& operator=(const AsioGuest&) = delete;

  boost::asio::io_context& context() { return context_; }
  Loop& loop() { return loop_; }

  // Schedules a turn for handlers that may be ready.
  void wake();

 private:
  void run();

  Loop& loop_;
  boost::asio::io_context context_{BOOST_ASIO_CONCURRENCY_HINT_UNSAFE};
  // Keeps the context from stopping when it has no work.
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_{
      context_.get_executor()};
  bool awake_ = false;
};

// A connected TCP socket, watched by the router's loop: Beast's AsyncStream. One read and one
// write at a time.
class GuestSocket {
 public:
  using executor_type = boost::asio::io_context::executor_type;
  using error_code = boost::system::error_code;
  using Done = boost::asio::any_completion_handler<void(error_code, std::size_t)>;

  GuestSocket(AsioGuest& guest, os::File socket);
  GuestSocket(const GuestSocket&) = delete;
  GuestSocket& operator=(const GuestSocket&) = delete;

  executor_type get_executor() { return guest_.context().get_executor(); }

  template <typename Buffers, typename Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return start(read_, buffers, std::forward<Token>(token));
  }
  template <typename Buffers, typename Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return start(write_, buffers, std::forward<Token>(token));
  }
  // Bytes acknowledged by the other host. When its receive buffer is full, this grows only as
  // fast as the program there reads.
  [[nodiscard]] std::uint64_t bytes_acknowledged() const;
  // Shuts down sending, and discards received data until the other side has closed too.
  void finish(Done done);
  // Pending operations complete with operation_aborted.
  void close();

 private:
  static constexpr std::size_t kPiecesMax = 16;
  // A pending operation.
  struct Transfer {
    ssize_t (GuestSocket::*step)(Transfer&);
    std::array<iovec, kPiecesMax> pieces{};
    std::size_t count = 0;
    std::size_t bytes = 0;
    std::optional<Done> done{};  // Done's own assignment recurses infinitely (Boost 1.81)
  };

  template <typename Buffers, typename Token>
  auto start(Transfer& transfer, const Buffers& buffers, Token&& token) {
    return boost::asio::async_initiate<Token, void(error_code, std::size_t)>(
        [this, &transfer](auto handler, const Buffers& pieces) {
          transfer.count = transfer.bytes = 0;
          for (auto it = boost::asio::buffer_sequence_begin(pieces);
               it != boost::asio::buffer_sequence_end(pieces) && transfer.count < kPiecesMax; ++it)
            add(transfer, *it);
          transfer.done.emplace(std::move(handler));
          go_on(transfer);
        },
        token, buffers);
  }
  static void add(Transfer& transfer, boost::asio::mutable_buffer piece);
  static void add(Transfer& transfer, boost::asio::const_buffer piece);

  ssize_t read_step(Transfer& transfer);
  ssize_t write_step(Transfer& transfer);
  ssize_t finish_step(Transfer& transfer);
  void go_on(Transfer& transfer);
  void end(Transfer& transfer, error_code error, std::size_t bytes);

  AsioGuest& guest_;
  os::File socket_;
  std::uint64_t bytes_written_ = 0;
  Transfer read_{.step = &GuestSocket::read_step};
  Transfer write_{.step = &GuestSocket::write_step};
  std::optional<Watch> watch_;
};

// Called by Beast at the end.
inline void beast_close_socket(GuestSocket& socket) { socket.close(); }
void teardown(boost::beast::role_type role, GuestSocket& socket, GuestSocket::error_code& error);
template <typename Handler>
void async_teardown(boost::beast::role_type, GuestSocket& socket, Handler&& handler) {
  socket.finish([h = std::forward<Handler>(handler)](GuestSocket::error_code error,
                                                     std::size_t) mutable { std::move(h)(error); });
}

}  // namespace tims::io

// One connection that is TLS outside and plain bytes inside, without waiting and without a thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "os/file.h"
#include "security/crypto/tls_session.h"
#include "tims/time.h"

namespace tims::security {

// What a connection has turned out to be.
struct Opened {
  os::File socket;  // plain bytes: one end of a pair, or the connection itself if it is not TLS
  bool is_tls = false;
  std::vector<Certificate> chain{};  // verified, of the other side; may be empty
};

struct Relayed {
  os::File socket;                  // connected, non-blocking
  std::optional<TlsContext> tls{};  // empty: TLS is not spoken here
  bool may_be_plain = false;        // of a server: handed on as it is, if it does not begin TLS
  os::File plain{};                 // the inner connection; none: a pair of sockets is made
  // Called once, by the thread of the relays, when the handshake is done.
  std::function<void(Opened)> on_open;
  // Called instead, with the reason.
  std::function<void(const std::string&)> on_refused = [](const std::string&) {};
  // Called when a connection by TLS is over, opened or refused.
  std::function<void()> on_end = [] {};
};

class TlsRelay {
 public:
  enum class State : std::uint8_t { kFirstByte, kHandshake, kOpen, kEnding, kOver };
  static constexpr std::size_t kChunkBytes = 64 << 10;

  TlsRelay(Relayed what, Time deadline);

  // Goes on as far as possible without waiting.
  void work(Time now);
  void on_deadline();

  // Call once, in state kOver.
  void tell_end() const {
    if (tls_) what_.on_end();
  }
  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] Time deadline() const { return deadline_; }  // kNever: none
  [[nodiscard]] int outer() const { return what_.socket.get(); }
  [[nodiscard]] int inner() const { return inner_.get(); }
  // What poll() shall wait for (POLLIN, POLLOUT).
  [[nodiscard]] short outer_events() const;
  [[nodiscard]] short inner_events() const;
  [[nodiscard]] const std::vector<Certificate>& chain() const { return chain_; }

 private:
  // Bytes that a socket has not taken yet.
  struct Waiting {
    Bytes bytes;
    std::size_t sent = 0;
    [[nodiscard]] bool empty() const { return sent == bytes.size(); }
    void add(View more);
    // False: the socket is broken.
    bool flush(int socket);
  };

  void look_at_first_byte();
  void begin_tls();
  void hand_on();
  void refuse(const std::string& reason);
  bool make_inner();
  void open();
  void exchange(Time now);
  bool receive();
  bool take_from_inner();
  void encrypted();
  void end_when_both_have(Time now);

  Relayed what_;
  State state_ = State::kFirstByte;
  Time deadline_;
  std::unique_ptr<TlsSession> tls_;
  Bytes chunk_;  // room for what is read
  os::File inner_;
  std::vector<Certificate> chain_;
  Waiting to_outer_;
  Waiting to_inner_;
  bool outer_ended_ = false;  // it sends no more
  bool inner_ended_ = false;
};

}  // namespace tims::security

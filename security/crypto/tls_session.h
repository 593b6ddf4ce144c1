// One TLS connection without a socket: bytes of the other side go in, bytes for it come out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "security/crypto/aead.h"
#include "security/crypto/certificate.h"
#include "security/crypto/tls_context.h"

namespace tims::security {

// Not for several threads at once; it may be handed from one to another.
class TlsSession {
 public:
  enum class State : std::uint8_t {
    kHandshake,
    kOpen,
    kClosed,  // the other side has ended the connection properly
    kFailed,  // error() states why; what take() still has is the alert for the other side
  };

  explicit TlsSession(const TlsContext& context);
  TlsSession(const TlsSession&) = delete;
  TlsSession& operator=(const TlsSession&) = delete;

  // Bytes that have come from the other side, in order. Goes on with the handshake; a client calls
  // it with nothing to begin. What it keeps is what was fed: the caller bounds it.
  State feed(View bytes);
  // The next bytes for the other side, at most `room`; empty: there are none.
  Bytes take(std::size_t room = 64 << 10);
  [[nodiscard]] std::size_t waiting() const;  // number of bytes that take() has

  // What the other side has written: the number of bytes, 0: none have come. Look at state() then.
  std::size_t read(std::span<std::byte> out);
  // Only in state kOpen. False: the connection has failed.
  bool write(View data);
  // Tells the other side that nothing more comes.
  void close();

  [[nodiscard]] State state() const { return state_; }
  // Why it failed: a sentence, either from `judge` or from OpenSSL; also what the other side's
  // alert says.
  [[nodiscard]] const std::string& error() const { return error_; }

  // From here on: in state kOpen.

  // The verified chain of the other side, its own certificate first, the root last. Empty: it sent
  // none.
  [[nodiscard]] std::vector<Certificate> peer_chain() const;
  [[nodiscard]] Suite suite() const;
  [[nodiscard]] std::string_view version() const;  // "TLSv1.3"
  // Keying material that only both ends of this connection have (RFC 8446, 7.5).
  [[nodiscard]] bool export_keys(std::string_view label, View context,
                                 std::span<std::byte> out) const;

 private:
  void advance();
  void fail();

  Handle<ssl_st> ssl_;
  bio_st* in_ = nullptr;   // owned by ssl_
  bio_st* out_ = nullptr;  // likewise
  State state_ = State::kHandshake;
  std::string refusal_;  // what `judge` said
  std::string error_;
};

// Where a refusal's text is written; null if the connection is not one of a TlsSession.
std::string* reason_of(const ssl_st* ssl);

}  // namespace tims::security

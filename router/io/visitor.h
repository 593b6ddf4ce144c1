// Who is at the other end of a connection that was accepted.
#pragma once

#include <optional>
#include <string>

#include <sys/types.h>

#include "security/crypto/certificate.h"

namespace tims::io {

struct Visitor {
  std::string peer{};                                  // "10.9.1.7:40312"; empty: a Unix socket
  bool is_tls = false;                                 // its bytes came through TLS
  std::optional<security::Certificate> certificate{};  // its own one, verified
  std::optional<uid_t> uid{};                          // its user, if it is on this host

  // Its packets did not leave this host.
  [[nodiscard]] bool is_on_this_host() const {
    return peer.empty() || peer.starts_with("127.") || peer.starts_with("[::1]");
  }
};

}  // namespace tims::io

// Two ends of TLS without a network, and an authority for their certificates. For tests.
#pragma once

#include <gtest/gtest.h>

#include "security/crypto/tls_session.h"

namespace tims::security {

struct TestPair {
  Certificate certificate;
  PrivateKey key;
};

inline TestPair test_root(const std::string& name) {
  auto key = PrivateKey::generate().value();
  Issue issue{.kind = Issue::Kind::kRoot,
              .subject = name,
              .uris = {},
              .host_names = {},
              .not_before = 1000,
              .not_after = 4000000000};
  auto certificate = issue.self_sign(key).value();
  return {certificate, key};
}
inline TestPair test_issued(const TestPair& by, Issue issue) {
  auto key = PrivateKey::generate().value();
  auto certificate = issue.sign(key, by.certificate, by.key).value();
  return {certificate, key};
}
inline TestPair test_member(const TestPair& by, std::vector<std::string> uris) {
  return test_issued(by, {.kind = Issue::Kind::kMember,
                          .subject = "member",
                          .uris = std::move(uris),
                          .host_names = {},
                          .not_before = 1000,
                          .not_after = 4000000000});
}

// Carries bytes between both until nothing moves.
inline void converse(TlsSession& client, TlsSession& server) {
  client.feed({});
  while (client.waiting() > 0 || server.waiting() > 0) {
    server.feed(client.take());
    client.feed(server.take());
  }
}

inline std::string read_text(TlsSession& session) {
  Bytes room(64 << 10);
  room.resize(session.read(room));
  return std::string(text_of(room));
}

}  // namespace tims::security

// Joining and renewing: what is asked, what the authority answers. No socket: a request and what
// TLS knows about its sender go in, an answer comes out.
//
// Both are fields (2 bytes size, least significant first, then the bytes), after 4 bytes with the
// size of all of them:
//   join    "join1", token id, proof (32 bytes), request for a certificate (PEM)
//   renew   "renew1", request for a certificate (PEM); the TLS connection proves who asks
//   answer  "ok", chain (PEM), roots (PEM), list; or "no", reason
// The list may be larger than 64 kB: it is the rest behind the fields before it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "security/keys/authority.h"
#include "security/keys/join_text.h"
#include "security/keys/tokens.h"

namespace tims::security {

inline constexpr std::size_t kRequestBytesMax = 16 << 10;
inline constexpr std::size_t kAnswerBytesMax = (1 << 20) + (64 << 10);
// TLS exporter's label (RFC 8446, 7.5); the prefix needs no registration.
inline constexpr std::string_view kJoinLabel = "EXPERIMENTAL tims join";

struct JoinRequest {
  bool renews = false;
  std::string token;  // of a join
  Digest proof{};     // likewise
  std::string pem;    // the request for a certificate

  [[nodiscard]] Bytes encode() const;  // without the size of all
  static Result<JoinRequest> parse(View bytes);
};

struct JoinAnswer {
  std::string refused;  // why; empty: accepted
  std::string chain;
  std::string roots;
  Bytes list;

  [[nodiscard]] Bytes encode() const;
  static Result<JoinAnswer> parse(View bytes);
};

// Who asks, as TLS and the socket know.
struct Asker {
  std::string source;                 // numeric address
  Bytes keys;                         // exported: 32 bytes
  std::optional<Certificate> proven;  // of a member, verified
};

// At most five wrong tokens a minute from one address; at most 1024 addresses are remembered.
class GuessLimit {
 public:
  [[nodiscard]] bool allows(const std::string& source, std::int64_t now);
  void count(const std::string& source, std::int64_t now);

 private:
  struct Guesses {
    std::int64_t since = 0;
    int count = 0;
  };
  void forget_old(std::int64_t now);

  std::map<std::string, Guesses> guesses_;
  Guesses others_;  // of all addresses beyond the 1024
};

class JoinDesk {
 public:
  explicit JoinDesk(KeyFolder keys) : keys_(std::move(keys)) {}

  // Reads the authority anew each time: timsctl may have changed it. A retry with the same key gets
  // the same certificate.
  JoinAnswer answer(const JoinRequest& request, const Asker& asker, std::int64_t now);

 private:
  JoinAnswer join(const Authority& authority, const JoinRequest& request, const Asker& asker,
                  std::int64_t now);
  JoinAnswer renew(const Authority& authority, const JoinRequest& request, const Asker& asker,
                   std::int64_t now);
  static JoinAnswer issue(const Authority& authority, const Identity& identity,
                          const CertificateRequest& request, const Asker& asker, std::int64_t now);

  KeyFolder keys_;
  GuessLimit guesses_;
};

// What a member expects of an answer.
struct Expected {
  std::optional<std::array<std::byte, 16>> root{};  // how the fingerprint of one root begins
  std::optional<Identity> identity{};               // of who renews: the present one
  // A person has decided it: what the folder has of another authority may be forgotten.
  bool another_fleet = false;
};

// What a member does with an answer: takes certificate, roots and list over. The own key is that of
// KeyFolder::next_key(). Who is a member already believes the authority that it believes, and no
// root that the answer names, unless `another_fleet`. After an error (kRefused, kMalformed), all
// files are as before.
Result<Identity> take_over(const KeyFolder& keys, const JoinAnswer& answer,
                           const Expected& expected);

}  // namespace tims::security

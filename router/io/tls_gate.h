// Where connections of the network pass before a port sees them: whether they speak TLS, and who
// they are. Handshakes and encryption run in the thread of security/relay, not in the loop.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "os/file.h"
#include "router/io/log.h"
#include "router/io/loop.h"
#include "router/io/visitor.h"
#include "security/crypto/tls_context.h"
#include "security/keys/credentials.h"
#include "security/relay/tls_relays.h"

namespace tims::io {

class TlsGate {
 public:
  enum class Kind : std::uint8_t { kTcp, kHttp };
  // How one port lets in.
  struct Entrance {
    Kind kind = Kind::kTcp;
    std::function<bool(const Visitor&)> may_be_plain{};
  };
  using OnConnection = std::function<void(os::File socket, Visitor visitor)>;

  // Members of the fleet with their certificates, and browsers, which have none.
  struct Contexts {
    security::TlsContext members;
    security::TlsContext browsers;
  };

  // The files (PEM) are for browsers; empty: they are shown the member's certificate. Errors name
  // the file, and what to do.
  static Result<Contexts> contexts_of(const security::Credentials& own,
                                      const security::Strictness& strictness,
                                      const std::string& certificate, const std::string& key);
  static Result<std::unique_ptr<TlsGate>> open(Loop& loop, LimitedLog& log, Contexts contexts);
  TlsGate(const TlsGate&) = delete;
  TlsGate& operator=(const TlsGate&) = delete;
  ~TlsGate();

  // For connections to come.
  void set_contexts(Contexts contexts) { contexts_ = std::move(contexts); }
  // Ends the connections whose certificates are one of these: the member's, then the issuing one.
  void end_if(std::function<bool(const std::vector<security::Certificate>&)> which);
  // Calls `on_connection` from the loop, with a socket that carries plain bytes; or closes it.
  void take(os::File socket, Visitor visitor, const Entrance& entrance, OnConnection on_connection);

 private:
  TlsGate(Loop& loop, LimitedLog& log, Contexts contexts,
          std::unique_ptr<security::TlsRelays> relays);

  Loop& loop_;
  LimitedLog& log_;
  Contexts contexts_;
  std::unique_ptr<security::TlsRelays> relays_;
};

}  // namespace tims::io

// Whether the router at the other end of a connection is the one that was dialled. All routers of a
// fleet have certificates that are right: without this, one on the path, of a stolen robot for
// example, could answer for any other.
#pragma once

#include <string>

#include "security/keys/credentials.h"

namespace tims::security {

struct Dialled {
  std::string host;    // a name, or a numeric address
  std::string name{};  // of the router, in its certificate; empty: whichever has this host
};

// Without a name, the host must be among the host names and addresses of the router's certificate:
// names compared without regard to case, addresses by their value. At loopback, any router of the
// fleet is accepted: what answers there runs on this host or was led there by somebody on it, not
// by somebody on the network. The refusal names what the certificate says, and what to write.
std::optional<Refusal> judge_dialled(const Dialled& dialled, const Certificate& certificate);

// TLS to the router that was dialled: no byte passes before it is known to be that one.
TlsSettings dialling_settings(const Credentials& own, Dialled dialled);

}  // namespace tims::security

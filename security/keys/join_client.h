// Joining and renewing over TCP: the side of a member.
#pragma once

#include <string>
#include <vector>

#include "security/keys/join_desk.h"
#include "tims/time.h"

namespace tims::security {

// Joins the fleet of the text: makes a key in the folder, proves the secret to the base over TLS
// whose root is the one in the text, and takes the certificate over. Interrupted at any moment, it
// may be called again. The addresses of the text are tried one after the other.
Result<Identity> join_fleet(const KeyFolder& keys, const JoinText& text, Time deadline);

// Gets a new certificate for a new key from the authority: at `hosts`, then where join_fleet() has
// found it. Whoever else answers there changes nothing, and the next address is tried.
Result<Identity> renew_certificate(const KeyFolder& keys, std::vector<std::string> hosts,
                                   Time deadline);

}  // namespace tims::security

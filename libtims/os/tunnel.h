// A connection through TLS without a TLS library in this program: `timsctl tunnel` carries it.
#pragma once

#include <string>

#include "os/file.h"
#include "tims/result.h"

namespace tims::os {

// Starts `timsctl` (find_program()) with one end of a pair of sockets; the other
// one is returned, non-blocking. `router`: HOST:PORT[/NAME] (wire/endpoint.h). The tunnel takes the
// keys of $TIMS_KEYS or /etc/tims/keys and ends with the connection; it reports on stderr why it
// cannot be made, and the connection ends then. kSystem: timsctl cannot be started.
Result<File> connect_by_tunnel(const std::string& router);

}  // namespace tims::os

// Who may talk to this port from a browser. A page of any site can make a browser send requests
// here; what it cannot do is forge the Host and Origin fields.
#pragma once

#include <string_view>

namespace tims::io {

// A Host field that is a number or "localhost", with or without a port. A site that points its own
// name at this machine (DNS rebinding) comes with that name.
bool is_safe_host(std::string_view host);

// An Origin field of a page that this machine itself has served: "http://localhost:8080",
// "https://127.0.0.1", "http://[::1]:3000". Not "null", which any site can be.
bool is_loopback_origin(std::string_view origin);

}  // namespace tims::io

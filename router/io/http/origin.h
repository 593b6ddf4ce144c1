// Who may talk to this port from a browser. A page of any site can make a browser send requests
// here; what it cannot do is forge the Host and Origin fields. `origins`: http.origins, pages from
// elsewhere that are welcome ("http://robot7:3000").
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace tims::io {

// A Host field that is a number or "localhost", with or without a port, or that of one of
// `origins`. A site that points its own name at this machine (DNS rebinding) comes with that name.
bool is_safe_host(std::string_view host, std::span<const std::string> origins = {});

// An Origin field of a page that came from here, "http://" and what the Host field says, or from
// one of `origins`. Pages of other ports are strangers, on this machine too: any user may serve
// them. So is "null", which any site can be.
bool is_safe_origin(std::string_view origin, std::string_view host,
                    std::span<const std::string> origins = {});

}  // namespace tims::io

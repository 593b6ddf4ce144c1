// Which router -H names.
#pragma once

#include <string_view>

#include "wire/endpoint.h"

namespace timsctl {

using UnixHost = tims::wire::UnixEndpoint;
using TcpHost = tims::wire::TcpEndpoint;
using Host = tims::wire::Endpoint;

// Throws Failure when it names none.
Host parse_host(std::string_view text);

}  // namespace timsctl

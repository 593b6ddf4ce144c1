// The configuration of the router, and what its parts get from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "router/config/config.h"
#include "router/config/load.h"
#include "router/config/networks.h"
#include "router/core/newest_values.h"
#include "router/core/router.h"
#include "router/io/arguments.h"
#include "router/io/http/http_port.h"
#include "router/link/links.h"
#include "router/policy/policy.h"

namespace tims::program {

// The files and values that the arguments name. The error: a file cannot be read.
Result<config::Loaded> load_configuration(const io::Arguments& arguments);

// --- of a configuration without problems

// `epoch`: chosen at start; of a router that goes on after a restart, that of the former one.
core::RouterSettings router_settings(const config::Config& config, std::uint64_t epoch);
link::Identity identity(const config::Config& config, std::uint64_t epoch);

std::vector<core::StaticRoute> static_routes(const config::Config& config);

// Address space, not memory, for messages that wait: at least 256 MiB, and 16 full queues.
std::size_t waiting_bytes(const config::Config& config);

io::BrowserAccess browser_access(const config::Config& config);

// Networks whose connections to the TCP port need no TLS. What cannot be parsed lets nobody in.
config::Networks plain_networks(const config::Config& config);

core::NewestRule newest_rule(const config::Config& config);

policy::PolicyText policy_text(const config::Loaded& loaded);
policy::Policy policy_of(const config::Loaded& loaded);

}  // namespace tims::program

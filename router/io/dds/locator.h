// Where RTPS sends to and listens (IPv4 and UDP), and addresses of ours.
#pragma once

#include <string>

#include <fastdds/rtps/common/Locator.h>

#include "router/link/net_address.h"

namespace tims::io {

using Locator = eprosima::fastdds::rtps::Locator;

// `host`: "10.9.1.1"; 0.0.0.0 stands for all addresses.
Locator locator_at(const std::string& host, std::uint16_t port);
Locator locator_of(const link::NetAddress& address);
link::NetAddress address_of(const Locator& locator);

}  // namespace tims::io

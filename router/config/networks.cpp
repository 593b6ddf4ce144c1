#include "router/config/networks.h"

#include <algorithm>
#include <string>

#include "router/config/config.h"

namespace tims::config {

Result<Networks> Networks::parse(std::string_view list) {
  Networks networks;
  for (const std::string& item : list_of(std::string(list))) {
    if (item == "loopback") {
      networks.networks_.push_back(*base::IpNetwork::parse("127.0.0.0/8"));
      networks.networks_.push_back(*base::IpNetwork::parse("::1"));
      continue;
    }
    const auto network = base::IpNetwork::parse(item);
    if (!network)
      return Error(Errc::kInvalidArgument,
                   "\"" + item +
                       "\" is not a network: write \"loopback\", \"10.9.0.0/16\" or "
                       "\"fd00::/8\", separated by commas");
    networks.networks_.push_back(*network);
  }
  return networks;
}

bool Networks::contains(std::string_view endpoint) const {
  std::string_view host = endpoint.substr(0, endpoint.rfind(':'));
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  const auto address = base::IpNetwork::parse(host.substr(0, host.find('%')));  // without its scope
  return address && std::ranges::any_of(networks_, [&](const base::IpNetwork& network) {
           return network.contains(*address);
         });
}

}  // namespace tims::config

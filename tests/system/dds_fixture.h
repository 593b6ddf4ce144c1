// Routers of one fleet that discover each other by name, with links over DDS.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <gmock/gmock.h>
#include <unistd.h>

#include "tests/support/eventually.h"
#include "tests/support/two_networks.h"
#include "tests/system/host.h"
#include "tests/system/traffic.h"

namespace tims::test {

// A fleet name that other tests on this machine do not use.
inline std::vector<std::string> fleet_settings(const std::string& more = "sim.faults=false") {
  return {"security.insecure=true", "fleet.name=test" + std::to_string(::getpid()), more};
}

inline std::unique_ptr<Host> fleet_host(const std::string& name, const std::string& role,
                                        int system, int id, const std::string& paths = "udp+dds",
                                        const std::string& more = "sim.faults=false") {
  std::vector<std::string> links;
  if (role != "subsystem") links.push_back("kind=sub,paths=" + paths);
  if (role != "top") links.push_back("kind=super,to=auto,paths=" + paths);
  auto host = std::make_unique<Host>(name, role, system, id, links, fleet_settings(more));
  host->listen_at("0.0.0.0:2010");
  return host;
}

// The router's status of its link to `peer`; null: no link.
inline boost::json::value link_of(const Host& host, std::string_view peer) {
  namespace json = boost::json;
  boost::system::error_code error;
  const json::value answer = json::parse(host.timsctl({"link", "show", "--json"}), error);
  if (error || answer.as_object().if_contains("items") == nullptr) return nullptr;
  for (const json::value& item : answer.at("items").as_array()) {
    const json::value& name = item.at("peer");
    if (name.is_string() && name.as_string() == peer) return item;
  }
  return nullptr;
}

// Waits until the link to `peer` is up and this router sends over that path.
inline testing::AssertionResult goes_by(const Host& host, const std::string& peer,
                                        const std::string& path, Duration within = kPatience) {
  return eventually(
      [&]() -> std::string {
        const boost::json::value link = link_of(host, peer);
        if (link.is_null()) return "no link to " + peer;
        const bool good = link.at("state") == "up" && link.at("path").as_string() == path;
        return good ? "" : "link to " + peer + ": " + boost::json::serialize(link);
      },
      within);
}

}  // namespace tims::test

// Routers of one fleet that discover each other by name, with links over DDS.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <gmock/gmock.h>
#include <unistd.h>

#include "tests/system/host.h"
#include "tests/system/traffic.h"
#include "tests/system/two_hosts_fixture.h"

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

}  // namespace tims::test

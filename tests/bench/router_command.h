// How a router is started.
#pragma once

#include <string>
#include <vector>

namespace tims::bench {

inline std::vector<std::string> router_command(const std::string& program,
                                               const std::string& socket,
                                               std::vector<std::string> settings) {
  // A queue that holds every window of any scenario, and room for all clients, of which a quarter
  // is kept for those of this host: what a measurement loses is a mistake.
  settings.insert(settings.end(), {"unix.path=" + socket, "http.listen=off", "tcp.queue=16MiB",
                                   "limits.clients=4096"});
  std::vector<std::string> command{program};
  for (std::string& setting : settings) {
    command.emplace_back("--set");
    command.push_back(std::move(setting));
  }
  return command;
}

}  // namespace tims::bench

// The command that starts a router.
#pragma once

#include <string>
#include <vector>

namespace tims::bench {

inline std::vector<std::string> router_command(const std::string& program,
                                               const std::string& socket,
                                               std::vector<std::string> settings) {
  // The queue holds every window of any scenario, and the limit of clients includes the quarter
  // that is reserved for those of this host; so no measurement may lose messages.
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

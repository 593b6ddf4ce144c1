#include <cstring>
#include <functional>
#include <map>
#include <string>

#include "components/demo/program.h"

int main(int argc, char** argv) {
  using namespace tims::demo;
  const std::map<std::string, std::function<int(tims::Session&, const StopSignals&)>> roles{
      {"ladar", run_ladar}, {"viewer", run_viewer}, {"server", run_server}, {"client", run_client}};
  const auto role = argc == 2 ? roles.find(argv[1]) : roles.end();
  if (role == roles.end()) {
    const bool help = argc == 2 && std::strcmp(argv[1], "--help") == 0;
    std::fprintf(help ? stdout : stderr,
                 "usage: tims-demo ladar|viewer|server|client\n"
                 "A small component for the router at $TIMS_ROUTER (default: the host's).\n");
    return help ? 0 : 2;
  }
  const StopSignals signals;  // before the session starts its thread
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  auto session = tims::Session::connect(
      {.name = std::string("demo-") + argv[1], .timeout = std::chrono::seconds(10)});
  if (!session) return failed("tims-demo", session.error());
  return role->second(*session, signals);
}

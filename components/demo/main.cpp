#include <functional>
#include <map>
#include <string>
#include <vector>

#include "components/demo/program.h"

int main(int argc, char** argv) {
  using namespace tims::demo;
  using Run = std::function<int(tims::Session&, const StopSignals&, const Arguments&)>;
  const std::map<std::string, Run> roles{
      {"ladar", run_ladar}, {"viewer", run_viewer}, {"server", run_server}, {"client", run_client}};
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (!words.empty() && words.front() == "--help") {
    std::fputs(usage().c_str(), stdout);
    return 0;
  }
  const auto parsed = parse_arguments(words);
  if (const auto* wrong = std::get_if<std::string>(&parsed)) {
    std::fprintf(stderr, "tims-demo: %s\n%s", wrong->c_str(), usage().c_str());
    return 2;
  }
  const auto& arguments = std::get<Arguments>(parsed);
  const StopSignals signals;  // before the session starts its thread
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  auto session = tims::Session::connect(
      {.name = "demo-" + arguments.role, .timeout = std::chrono::seconds(10)});
  if (!session) return failed("tims-demo", session.error());
  return roles.at(arguments.role)(*session, signals, arguments);
}

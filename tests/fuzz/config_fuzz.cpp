// A configuration is refused with a location for every error, or it is printed in a form that loads
// to the same values.
#include "router/config/load.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tims;
  const config::Host host{.name = "robot1", .uid = 0, .environment = {{"ID", "7"}}};
  fuzz::Input input(data, size);
  const std::string text(input.text());
  // The text as a file, and its first line as an option --set.
  const config::Loaded loaded = config::load({{{"fuzz.toml", text}}, {}, host});
  fuzz::use(config::load({{}, {text.substr(0, text.find('\n'))}, host}));
  for (const config::Problem& problem : loaded.problems) {
    fuzz::require(problem.at.line > 0 && !problem.text.empty());
    fuzz::use(problem.to_string());
  }
  if (!loaded.ok()) return 0;
  const std::string printed = config::print_config(loaded.config, loaded.origins);
  const config::Loaded again = config::load({{{"printed.toml", printed}}, {}, host});
  fuzz::require(again.ok() && again.config == loaded.config);
  return 0;
}

// tims-router: reads its arguments and its configuration, and runs.
#include <cstdio>
#include <new>
#include <span>
#include <string_view>

#include <unistd.h>

#include "router/config/load.h"
#include "router/config/options.h"
#include "router/io/arguments.h"
#include "router/io/net/resolver.h"
#include "router/io/service.h"
#include "router/program/program.h"
#include "router/program/settings.h"

namespace tims {
namespace {

constexpr int kWrongUsage = 2;

// The system refuses memory, because of a limit or because there is none. What was begun cannot be
// completed without it; a sentence is better than the name of an exception. Called instead of
// throwing it, in every thread.
[[noreturn]] void end_without_memory() {
  constexpr std::string_view kText =
      "tims-router: the system refuses more memory: raise the limit of the process (ulimit -v, "
      "ulimit -d; LimitAS, MemoryMax of its service), or lower tcp.queue, "
      "http.queue and message.max\n";
  (void)!::write(STDERR_FILENO, kText.data(), kText.size());
  ::_exit(program::kCannotStart);
}

int print(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
  return std::fflush(stdout) == 0 ? 0 : program::kCannotStart;
}

int complain(std::string_view text, int status) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fputc('\n', stderr);
  return status;
}

int main(std::span<const char* const> argv) {
  using Action = io::Arguments::Action;
  const auto arguments = io::parse_arguments(argv);
  if (!arguments) {
    return complain(arguments.error().detail() + "; see tims-router --help", kWrongUsage);
  }
  if (arguments->action == Action::kVersion) return print("tims-router " TIMS_VERSION "\n");
  if (arguments->action == Action::kHelp) {
    return print(io::usage() + "\nKeys and values:\n" + config::options_help());
  }
  auto loaded = program::load_configuration(*arguments);
  if (!loaded) return complain(loaded.error().message(), program::kCannotStart);
  for (const auto& problem : loaded->problems) complain(problem.to_string(), program::kCannotStart);
  if (!loaded->ok()) return program::kCannotStart;
  if (arguments->action == Action::kCheck) {
    for (const std::string& caution : config::cautions(loaded->config)) complain(caution, 0);
    return print("the configuration is valid\n");
  }
  if (arguments->action == Action::kPrintConfig) {
    return print(config::print_config(loaded->config, loaded->origins));
  }
  io::raise_descriptor_limit();
  io::limit_name_servers();
  return program::run(std::move(*loaded), *arguments);
}

}  // namespace
}  // namespace tims

int main(int count, char** argv) {
  std::set_new_handler(tims::end_without_memory);
  return tims::main(
      {const_cast<const char* const*>(argv) + 1, static_cast<std::size_t>(count) - 1});
}

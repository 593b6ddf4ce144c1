#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tims/session.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"

namespace timsctl {
namespace {

bool no_color() {
  const char* asked = std::getenv("NO_COLOR");
  const char* term = std::getenv("TERM");
  return (asked != nullptr && *asked != 0) || term == nullptr || std::string_view(term) == "dumb";
}

// -H, else $TIMS_HOST, else the router that programs of this host use.
Host router_of(const Options& options) {
  if (!options.host.empty()) return parse_host(options.host);
  const char* host = std::getenv("TIMS_HOST");
  if (host != nullptr && *host != 0) return parse_host(host);
  return parse_host(tims::default_router());
}

// Errors of the command line are answered as JSON too, when it asks for JSON.
Options for_errors(const std::vector<std::string>& arguments) {
  Options options;
  std::string_view before;
  for (const std::string& word : arguments) {
    const bool short_form = word == "-j" || word == "-ojson" || (before == "-o" && word == "json");
    if (short_form || word == "--json" || word == "--json-lines" || word == "--output=json")
      options.format = Format::kJson;
    before = word;
  }
  return options;
}

Exit run(const Command& command, Output& out, const Signals& signals) {
  Context context(command.options, out, signals, router_of(command.options));
  try {
    return command.verb->run(context);
  } catch (const Interrupted&) {
    // A verb without an end of its own is done when it is stopped.
    return command.verb->endless && command.options.endless() ? Exit::kDone : Exit::kInterrupted;
  }
}

Exit run(const std::vector<std::string>& arguments) {
  const Signals signals;  // before any thread
  Output out(for_errors(arguments), true);
  try {
    const auto parsed = parse_command_line(arguments);
    if (const auto* text = std::get_if<Text>(&parsed)) {
      out.write(text->text);
      return Exit::kDone;
    }
    const auto& command = std::get<Command>(parsed);
    out = Output(command.options, no_color());
    return run(command, out, signals);
  } catch (const Failure& failure) {
    out.failure(failure);
    return failure.exit;
  } catch (const Interrupted&) {
    return Exit::kInterrupted;
  } catch (const std::exception& error) {
    out.failure({Exit::kVersion, "unexpected_answer", error.what(),
                 "the router's answer has another form than expected: another version?"});
    return Exit::kVersion;
  }
}

}  // namespace
}  // namespace timsctl

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  return static_cast<int>(timsctl::run(arguments));
}

// timsctl deploy: a robot's packages, configuration and keys on all of its hosts.
#include "tools/cli/context.h"
#include "tools/cli/program.h"
#include "tools/deploy/deployer.h"

namespace timsctl {
namespace {

Exit run_deploy(Context& context) {
  return deploy::Deployer(context, deploy::read_order(context)).run();
}

}  // namespace
}  // namespace timsctl

int main(int argc, char** argv) {
  using namespace timsctl;
  static constexpr VerbRun kRuns[] = {{"deploy", run_deploy}};
  const VerbProgram program{
      "timsctl-deploy", "bring packages, configuration and keys to the hosts of a robot.", kRuns,
      [](std::string_view, std::size_t) { return std::vector<std::string>(); }};
  return run_program(argc, argv, program);
}

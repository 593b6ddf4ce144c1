#include "tools/cli/program.h"
#include "tools/timsctl/command_line.h"

int main(int argc, char** argv) {
  return timsctl::run_program(argc, argv, timsctl::timsctl_program());
}

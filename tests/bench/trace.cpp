#include "tests/bench/trace.h"

#include <filesystem>
#include <fstream>
#include <sstream>

namespace tims::bench {
namespace {

constexpr const char* kStrace = "/usr/bin/strace";

}  // namespace

bool can_trace() { return std::filesystem::exists(kStrace); }

std::vector<std::string> traced(const std::string& file) {
  return {kStrace, "--follow-forks", "--summary-only", "--summary-columns=calls,name",
          "--output=" + file};
}

Metrics counted(const std::string& file) {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    double calls = 0;
    std::string name;
    if (fields >> calls >> name && name == "total") return {{raw::kSystemCalls, calls}};
  }
  return {};
}

}  // namespace tims::bench

// What a host answers to a deployment, and the index of a folder of packages. Whatever it is, only
// names that may be deployed come out, versions have an order, and what is shown moves no cursor.
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/fuzz_input.h"
#include "tools/deploy/answers.h"
#include "tools/deploy/repository.h"

namespace {

using namespace timsctl::deploy;
namespace fuzz = tims::fuzz;

bool is_shown_safely(const std::string& text) {
  return std::ranges::none_of(text, [](char c) { return (c >= 0 && c < ' ') || c == 0x7F; });
}

void check_answers(std::string_view text) {
  const Facts facts = facts_of(text);
  for (const auto& [name, file] : facts.files)
    fuzz::require(is_deployed_name(name) && file.sha256.size() == 64);
  for (const PackageChange& change : changes_of(text)) fuzz::require(!change.name.empty());
  const Progress progress = progress_of(text);
  fuzz::require(is_shown_safely(progress.reason) && is_shown_safely(reason_in(text)));
  for (const std::string& step : progress.steps) fuzz::require(is_shown_safely(step));
}

void check_index(std::string_view text) {
  const std::vector<Package> all = packages_in(text);
  std::vector<std::string> wanted;
  for (const Package& package : all) {
    fuzz::require(package.file.find('/') == std::string::npos && package.size > 0);
    wanted.push_back(package.name);
    const std::string& first = all.front().version;
    const int order = compare_versions(first, package.version);
    const int back = compare_versions(package.version, first);
    fuzz::require((order < 0) == (back > 0) && (order == 0) == (back == 0));
  }
  fuzz::require(needed(all, wanted, "amd64").size() <= all.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  check_answers(text);
  check_index(text);
  return 0;
}

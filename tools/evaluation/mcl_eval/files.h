// What programs that judge recorded drives share: a drive out of its files, the time that judging
// takes, figures as a line. What is wrong with a file is thrown as a Failure that names it.
#pragma once

#include <string>
#include <vector>

#include <fmt/core.h>

#include "components/localisation/grid_map.h"
#include "components/localisation/likelihood_field.h"
#include "tools/cli/failure.h"

namespace rack::mcl_eval {

struct Files {
  std::string log;
  std::string map;
  std::string truth;
};

std::string read_file(const std::string& name);
localisation::GridMap read_map(const std::string& name);

// What was made of the file, or the Failure.
template <typename T>
T well(tims::Result<T> result, const std::string& file) {
  if (!result)
    throw timsctl::Failure(timsctl::Exit::kNo, "bad_file",
                           fmt::format("{}: {}", file, result.error().detail()));
  return std::move(result).value();
}

localisation::LikelihoodField field_of(const localisation::GridMap& map, const std::string& file);

// us of this thread alone: others on this machine do not count.
double stopwatch_us();

struct Field {
  std::string name;
  double value;
  int digits;
};
// "name=value name=value", or the inside of a JSON object.
std::string line_of(const std::vector<Field>& fields, bool json);
// That line, or the JSON object; whoever reads it has it at once.
void print_line(const std::vector<Field>& fields, bool json);

}  // namespace rack::mcl_eval

// Common functions of evaluation programs: reading the files of a drive, measuring time, printing
// results. Errors of a file are thrown as a Failure with its name.
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

// Returns the value, or throws a Failure with the name of the file.
template <typename T>
T well(tims::Result<T> result, const std::string& file) {
  if (!result)
    throw timsctl::Failure(timsctl::Exit::kNo, "bad_file",
                           fmt::format("{}: {}", file, result.error().detail()));
  return std::move(result).value();
}

localisation::LikelihoodField field_of(const localisation::GridMap& map, const std::string& file);

// CPU time of this thread, us; other load on the machine does not count.
double stopwatch_us();

struct Field {
  std::string name;
  double value;
  int digits;
};
// "name=value name=value", or the members of a JSON object.
std::string line_of(const std::vector<Field>& fields, bool json);
// Prints that line, or the JSON object, and flushes.
void print_line(const std::vector<Field>& fields, bool json);

}  // namespace rack::mcl_eval

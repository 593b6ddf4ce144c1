// A recorded drive out of its files, and the time that judging it takes. What is wrong with them is
// thrown as a Failure that names the file.
#pragma once

#include <string>

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

}  // namespace rack::mcl_eval

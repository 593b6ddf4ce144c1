// tims-schema: all messages of RACK as text for programs in other languages.
#include <cstdint>
#include <string>

#include <fmt/core.h>

#include "proxies/catalogue_text.h"
#include "tools/cli/argument_parser.h"
#include "tools/cli/failure.h"

namespace rack::schema_program {
namespace {

using timsctl::Exit;

struct Wanted {
  bool types = false;
  bool vectors = false;
  std::uint64_t seed = 1;
};

constexpr const char* kAbout =
    "Prints all classes, structs and messages of RACK as JSON (described in proxies/README.md).";
constexpr const char* kExits =
    "Exit status: 0 done, 2 wrong command line.\n\n"
    "Example: tims-schema > console/src/codec/schema.json";

Exit print(const Wanted& wanted) {
  if (wanted.types && wanted.vectors)
    throw timsctl::usage_error("--types and --vectors exclude each other", "give one of them");
  const std::string text = wanted.types     ? catalogue_types()
                           : wanted.vectors ? catalogue_vectors(wanted.seed)
                                            : catalogue_json();
  fmt::print("{}", text);
  return Exit::kDone;
}

}  // namespace
}  // namespace rack::schema_program

int main(int argc, char** argv) {
  rack::schema_program::Wanted wanted;
  timsctl::ArgumentParser parser("tims-schema", rack::schema_program::kAbout,
                                 rack::schema_program::kExits);
  parser.flag("--types", wanted.types, "types of TypeScript instead");
  parser.flag("--vectors", wanted.vectors,
              "bodies with arbitrary content instead, and what they mean");
  parser.option("--seed", wanted.seed, "of the arbitrary content");
  return parser.run(argc, argv, [&] { return rack::schema_program::print(wanted); });
}

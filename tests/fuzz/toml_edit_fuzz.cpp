// An edit of a TOML text is refused with a place, or its result is valid and an edit back to the
// text of before is possible; whatever the text and the path.
#include "base/toml_edit.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tims;
  fuzz::Input input(data, size);
  const auto kind = input.number<std::uint8_t>();
  const std::string all(input.text());
  const std::size_t line = all.find('\n');
  const auto path = base::parse_toml_path(all.substr(0, line));
  if (!path || line == std::string::npos) return 0;
  fuzz::require(base::parse_toml_path(base::to_string(*path)) == path);
  const base::TextFile file{"fuzz.toml", all.substr(line + 1)};
  base::TomlOperation operation{
      .kind = static_cast<base::TomlOperation::Kind>(kind % 4), .path = *path, .name = "a b"};
  if (kind % 2 == 0)
    operation.value.value = base::TomlInput::Table{{"a b", {std::string("x\n\"")}}};
  else
    operation.value.value = std::int64_t{7};
  const base::TomlEdited edited = base::edited_toml(file, {&operation, 1});
  for (const base::Problem& problem : edited.problems) {
    fuzz::require(problem.at.line > 0 && !problem.text.empty());
    fuzz::require(edited.text == file.text);
  }
  fuzz::require(!edited.problems.empty() ||
                base::parse_toml({file.name, edited.text}).problems.empty());
  return 0;
}

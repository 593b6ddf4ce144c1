// Keys of configuration files that have another name now. Readers understand the former name, with
// a hint, until the next minor version; `timsctl config migrate` rewrites it. Pure.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "base/toml.h"
#include "base/toml_edit.h"

namespace tims::base {

struct RenamedKey {
  std::string_view path;     // "component[].parameters.reflectorFilter"; [] is each element
  std::string_view program;  // only of components with this program; empty: of all
  std::string_view name;     // now, of the path's last step
  std::string_view since;    // minor version: "0.2"
};

// In any kind of file: robots, worlds, routers.
std::span<const RenamedKey> renamed_keys();

struct FormerKey {
  TomlPath path;
  const RenamedKey* renamed = nullptr;
  Problem hint{};  // where it is, and what to do

  [[nodiscard]] TomlPath path_now() const;
  [[nodiscard]] TomlOperation renaming() const;
};

// In the order of the table.
std::vector<FormerKey> former_keys(const TomlTree& tree);

// Gives keys with a former name the name of now, so that readers know only this one. Returns the
// hints. A key that is there by both names keeps the former one, which readers refuse.
std::vector<Problem> rename_former_keys(TomlTree& tree);

// The text with the names of now, and otherwise the same bytes.
TomlEdited migrated(const TextFile& file);

}  // namespace tims::base

// The edits that `timsctl config diff` and `apply` take as arguments. Pure but for the texts of
// files.
//
//   robots/scout.toml=FILE                                        the text of a file of this host
//   robots/scout.toml:component[2].parameters.maxRange=10000     one value
//   robots/scout.toml:component[4]=                               without this value, table or
//   element arm@router.toml:log.level="debug"                             on the host of the router
//   arm
#pragma once

#include <string>
#include <string_view>

#include "tools/cli/output.h"

namespace timsctl {

struct ConfigEdit {
  std::string router;  // empty: that of -H and -r
  std::string file;
  std::string path;    // of the value; empty: the whole text
  std::string source;  // the value as TOML, else as a text; or the path of the file of this host
};

// Throws Failure: not an edit.
ConfigEdit parse_config_edit(std::string_view argument);

// A unified diff, painted for a terminal.
std::string diff_in_colour(std::string_view diff, bool colour);

// The operation of PROTOCOL.md for an edit with a path.
json::object operation_of(const ConfigEdit& edit);

}  // namespace timsctl

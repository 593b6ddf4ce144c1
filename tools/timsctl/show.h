// Verbs that ask something and show the answer, once or again and again (--watch).
#pragma once

#include <functional>
#include <span>
#include <string>

#include "tools/timsctl/context.h"

namespace timsctl {

using AskRouter = std::function<json::object(AdminClient&)>;
// From the answer to what a person reads; never called for JSON.
using Draw = std::function<std::string(const json::object&, const Look&)>;

Exit show(Context& context, const AskRouter& ask, const Draw& draw);

// A list: the answer's items as a table, ordered as --sort says.
Exit show_items(Context& context, const json::object& question, std::span<const Column> columns);
Exit show_items(Context& context, const json::object& question, std::span<const Column> columns,
                const Draw& draw);

// The question with "match" for the first argument, if there is one.
json::object with_match(json::object question, const Options& options);

}  // namespace timsctl

// timsctl errors: the catalogue, without a router.
#include <fmt/format.h>

#include "tools/timsctl/catalogue.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

namespace {

constexpr Column kColumns[] = {
    {"CODE", "code"}, {"KIND", "kind"}, {"MEANING", "meaning"}, {"HINT", "hint", As::kText, true}};

json::object to_json(const CatalogueEntry& entry) {
  return {
      {"code", entry.code}, {"kind", entry.kind}, {"meaning", entry.meaning}, {"hint", entry.hint}};
}

}  // namespace

Exit errors(Context& context) {
  json::array items;
  const auto& arguments = context.options.arguments;
  for (const CatalogueEntry& entry : catalogue())
    if (arguments.empty() || arguments.front() == entry.code) items.push_back(to_json(entry));
  if (items.empty())
    throw Failure(Exit::kNoSuch, "no_such_code", fmt::format("no code \"{}\"", arguments.front()),
                  "`timsctl errors` lists all");
  const Look& look = context.out.look();
  if (look.format == Format::kJson) {
    context.out.write(json::object{{"schema", "tims/code/1"}, {"items", std::move(items)}});
  } else if (arguments.empty() || look.format != Format::kTable) {
    context.out.write(render_items({items.data(), items.size()}, kColumns, look));
  } else {
    const CatalogueEntry& entry = *find_in_catalogue(arguments.front());
    context.out.write(fmt::format("{} ({}): {}\n", entry.code, entry.kind, entry.meaning));
    if (!entry.hint.empty()) context.out.write(fmt::format("  -> {}\n", entry.hint));
  }
  return Exit::kDone;
}

}  // namespace timsctl

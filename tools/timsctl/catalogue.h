// What the words mean that timsctl and the router use for what went wrong, and what to do.
#pragma once

#include <span>
#include <string_view>

namespace timsctl {

struct CatalogueEntry {
  std::string_view code;  // "no_route", "mailboxes.dead", "3"
  std::string_view kind;  // "reason", "error", "doctor", "exit status"
  std::string_view meaning;
  std::string_view hint;
};

std::span<const CatalogueEntry> catalogue();
const CatalogueEntry* find_in_catalogue(std::string_view code);

}  // namespace timsctl

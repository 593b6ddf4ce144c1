// What is said about names that nobody knows.
#pragma once

#include <string>
#include <string_view>

#include "router/config/options.h"

namespace tims::config {

bool is_table(std::string_view name);

std::string unknown_key(std::string_view key);
// Shown as it was written: "[tpc]", "[[lnk]]".
std::string unknown_table(std::string_view name, bool is_list);
std::string unknown_item_key(const List& list, std::string_view name);

}  // namespace tims::config

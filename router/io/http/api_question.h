// "/api/mailboxes?match=Ladar(*%2F*)&limit=10" as a question of the admin protocol (ADMIN.md):
// {"ask":"mailboxes","match":"Ladar(*/*)","limit":10}. Pure.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace tims::io {

// `query` is what stands behind the question mark. Nothing when an escape in it is broken. Whether
// the question makes sense is the admin protocol's business.
std::optional<std::string> api_question(std::string_view ask, std::string_view query);

}  // namespace tims::io

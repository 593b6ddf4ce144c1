// Admin questions that change something (ADMIN.md): links taken up and down, faults, static routes.
#pragma once

#include <optional>
#include <vector>

#include "router/io/admin_question.h"
#include "router/io/admin_source.h"

namespace tims::io {

inline constexpr std::size_t kStaticRoutesMax = 256;

// Does what the question asks for; else what is wrong.
std::optional<QuestionError> carry_out(const Question& question, const AdminSource& source);

// The static routes after a reload: those of the configuration, as it has changed from `before` to
// `after`, and what people have added and deleted at run time since.
std::vector<core::StaticRoute> reload_routes(const std::vector<core::StaticRoute>& running,
                                             const std::vector<core::StaticRoute>& before,
                                             const std::vector<core::StaticRoute>& after);

}  // namespace tims::io

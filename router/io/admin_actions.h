// Admin questions that change something (ADMIN.md): links taken up and down, faults, static routes.
#pragma once

#include <string>

#include "router/io/admin_question.h"
#include "router/io/admin_source.h"

namespace tims::io {

inline constexpr std::size_t kStaticRoutesMax = 256;

// Does what the question asks for; what is wrong, else empty.
std::string carry_out(const Question& question, const AdminSource& source);

}  // namespace tims::io

// Ids that nobody has used before: of changes, and of questions to other agents.
#pragma once

#include <string>

namespace timsctl {

// 16 hex digits, drawn at random.
std::string random_id();

}  // namespace timsctl

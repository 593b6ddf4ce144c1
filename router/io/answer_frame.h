// What all answers of the admin protocol (ADMIN.md) have in common.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <boost/json/object.hpp>

#include "router/io/admin_question.h"
#include "router/io/admin_source.h"

namespace tims::io {

inline constexpr std::size_t kAnswerBytesMax = 256 << 10;

// `schema`: name and version of the answer's format, for example "tims/status/1".
boost::json::object answer_frame(const AdminSource& source, const Clocks& clocks,
                                 std::string_view schema);

boost::json::object error_json(const QuestionError& error);
std::string error_text(const QuestionError& error);

}  // namespace tims::io

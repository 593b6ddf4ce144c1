// Answers of the admin protocol (ADMIN.md): what all have in common, and those to questions that
// change nothing, made from reports.h.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <variant>

#include <boost/json/object.hpp>

#include "router/core/router.h"
#include "router/io/admin_question.h"
#include "router/io/admin_source.h"

namespace tims::io {

inline constexpr std::size_t kAnswerBytesMax = 256 << 10;

// `schema`: name and version of the answer's format, for example "tims/status/1".
boost::json::object answer_frame(const AdminSource& source, const Clocks& clocks,
                                 std::string_view schema);

boost::json::object error_json(const QuestionError& error);
std::string error_text(const QuestionError& error);

// A router numbers its events from 1 after every start: a number of another epoch is meaningless
// here, and becomes 0.
std::variant<Question, QuestionError> read_question(std::string_view text,
                                                    const AdminSource& source, Time now);

// For questions that are only answered (Effect::kNone).
std::string answer_text(const Question& question, const AdminSource& source, const Clocks& clocks);

// Answers any bytes immediately: a question that would wait is answered with the current data,
// and one that would change something is refused.
std::string answer_admin(std::string_view question, const AdminSource& source,
                         const Clocks& clocks);

// Which events a question is about.
const core::EventLog& log_of(const Question& question, const core::Router& router);

}  // namespace tims::io

// Answers to questions that change nothing (ADMIN.md), made from reports.h.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "router/core/router.h"
#include "router/io/admin_question.h"
#include "router/io/admin_source.h"

namespace tims::io {

// A router numbers its events from 1 after every start: a number of another epoch is meaningless
// here, and becomes 0.
std::variant<Question, QuestionError> read_question(std::string_view text,
                                                    const AdminSource& source, Time now);

std::string answer_text(const std::variant<Question, QuestionError>& question,
                        const AdminSource& source, const Clocks& clocks);

// Answers any bytes immediately: a question that would wait is answered with the current data,
// and one that would change something is refused.
std::string answer_admin(std::string_view question, const AdminSource& source,
                         const Clocks& clocks);

// Which events a question is about.
const core::EventLog& log_of(const Question& question, const core::Router& router);

}  // namespace tims::io

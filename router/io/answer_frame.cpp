#include "router/io/answer_frame.h"

#include <utility>

#include <boost/json/serialize.hpp>

#include "base/text.h"

namespace tims::io {

using base::valid_utf8;

namespace json = boost::json;

json::object answer_frame(const AdminSource& source, const Clocks& clocks,
                          std::string_view schema) {
  return {{"schema", schema},
          {"router", valid_utf8(source.config().router.name)},
          {"time", base::rfc3339(clocks.wall)},
          {"partial", false}};
}

json::object error_json(const QuestionError& error) {
  json::object out{{"code", error.code}, {"message", valid_utf8(error.message)}};
  if (!error.hint.empty()) out["hint"] = error.hint;
  return {{"error", std::move(out)}};
}

std::string error_text(const QuestionError& error) { return json::serialize(error_json(error)); }

}  // namespace tims::io

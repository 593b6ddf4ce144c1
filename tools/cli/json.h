// Reading JSON without asking at every step whether it is there.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>

namespace timsctl {

namespace json = boost::json;

// "owner.name": the member of the member; nullptr when it is not there or null.
const json::value* at_path(const json::object& object, std::string_view path);
std::optional<double> number_at(const json::object& object, std::string_view path);
double number_or_zero(const json::object& object, std::string_view path);
// Texts as they are, other values as JSON; empty when not there.
std::string text_at(const json::object& object, std::string_view path);
// What is under "items", nothing when it is missing.
std::span<const json::value> items_of(const json::object& answer);
json::array& items_of(json::object& answer);

std::string to_text(const json::value& value);  // compact, one line

}  // namespace timsctl

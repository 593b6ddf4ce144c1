#include "tools/cli/json.h"

#include <boost/json/serialize.hpp>

namespace timsctl {

const json::value* at_path(const json::object& object, std::string_view path) {
  const json::object* in = &object;
  for (;;) {
    const std::size_t dot = path.find('.');
    const json::value* value = in->if_contains(path.substr(0, dot));
    if (value == nullptr || value->is_null()) return nullptr;
    if (dot == std::string_view::npos) return value;
    in = value->if_object();
    if (in == nullptr) return nullptr;
    path.remove_prefix(dot + 1);
  }
}

std::optional<double> number_at(const json::object& object, std::string_view path) {
  const json::value* value = at_path(object, path);
  if (value == nullptr || !value->is_number()) return std::nullopt;
  return value->to_number<double>();
}

double number_or_zero(const json::object& object, std::string_view path) {
  return number_at(object, path).value_or(0);
}

std::string text_at(const json::object& object, std::string_view path) {
  const json::value* value = at_path(object, path);
  if (value == nullptr) return {};
  if (const json::string* text = value->if_string()) return std::string(*text);
  return to_text(*value);
}

std::span<const json::value> items_of(const json::object& answer) {
  const json::value* items = answer.if_contains("items");
  const json::array* array = items == nullptr ? nullptr : items->if_array();
  if (array == nullptr) return {};
  return {array->data(), array->size()};
}

json::array& items_of(json::object& answer) {
  json::value& items = answer["items"];
  return items.is_array() ? items.get_array() : items.emplace_array();
}

std::string to_text(const json::value& value) { return json::serialize(value); }

}  // namespace timsctl

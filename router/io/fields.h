// A report is a struct, or a view of data stored elsewhere, whose fields are listed once: the
// name of each in JSON, how to get it and, for monitoring, the Prometheus metric it is exported
// as. The admin protocol's JSON (to_json) and the Prometheus page (metrics_text) are both
// generated from these lists, so neither can miss a field or use another unit.
#pragma once

#include <concepts>
#include <cstddef>
#include <functional>
#include <optional>
#include <string_view>
#include <tuple>
#include <type_traits>

#include <boost/json/object.hpp>

#include "base/measure.h"
#include "base/text.h"
#include "tims/time.h"

namespace tims::io {

struct Metric {
  int place = 0;  // position among the metrics of the same report; 0: not a metric
  std::string_view name{};
  std::string_view type{};
  std::string_view help{};
};
constexpr Metric counter(int place, std::string_view name, std::string_view help) {
  return {place, name, "counter", help};
}
constexpr Metric gauge(int place, std::string_view name, std::string_view help) {
  return {place, name, "gauge", help};
}

// `name`: in JSON. When it is empty, the fields of a nested report are inserted here; any other
// field is a metric only. `get`: a member of the report, or a function of it.
template <typename Get>
struct Field {
  constexpr Field(std::string_view its_name, Get its_get, Metric its_metric = {})
      : name(its_name), get(its_get), metric(its_metric) {}

  std::string_view name;
  Get get;
  Metric metric;
};

// Specialised for each report. `list`: a tuple of fields, in JSON order.
template <typename Report>
struct Fields;

template <typename T>
concept Described = requires { Fields<T>::list; };
template <typename T>
concept DescribedOptional = requires {
  typename T::value_type;
} && Described<typename T::value_type> && std::same_as<T, std::optional<typename T::value_type>>;

template <Described Report, typename Visit>
constexpr void for_each_field(Visit visit) {
  std::apply([&](const auto&... field) { (visit(field), ...); }, Fields<Report>::list);
}

template <typename Report, typename Get>
using FieldValue = std::remove_cvref_t<std::invoke_result_t<const Get&, const Report&>>;

// --- JSON

// Empty for an empty text or the number 0: null in JSON.
template <typename T>
std::optional<T> unless_empty(T value) {
  return value == T() ? std::optional<T>() : std::optional<T>(std::move(value));
}

template <Described Report>
boost::json::object to_json(const Report& report);

// SI units, names of enumerators, null for unknown values. Texts may contain arbitrary bytes and
// are converted to UTF-8.
template <typename T>
boost::json::value json_of(const T& value) {
  if constexpr (std::same_as<T, std::nullptr_t>)
    return value;
  else if constexpr (Described<T>)
    return to_json(value);
  else if constexpr (std::same_as<T, Duration>)
    return base::seconds(value);
  else if constexpr (std::is_enum_v<T>)
    return boost::json::string(name(value));
  else if constexpr (std::convertible_to<const T&, std::string_view>)
    return boost::json::string(base::valid_utf8(value));
  else if constexpr (requires { value.has_value(); })
    return value ? json_of(*value) : boost::json::value();
  else
    return boost::json::value(value);
}

// With a null `report`, every field is null.
template <Described Report>
void append_json(boost::json::object& out, const Report* report) {
  for_each_field<Report>([&]<typename Get>(const Field<Get>& field) {
    using Value = FieldValue<Report, Get>;
    if constexpr (Described<Value>) {
      if (field.name.empty()) {
        if (report == nullptr) return append_json<Value>(out, nullptr);
        const Value& inner = std::invoke(field.get, *report);
        return append_json(out, &inner);
      }
    } else if constexpr (DescribedOptional<Value>) {
      if (field.name.empty()) {
        const Value inner = report == nullptr ? Value() : std::invoke(field.get, *report);
        return append_json<typename Value::value_type>(out, inner ? &*inner : nullptr);
      }
    }
    if (!field.name.empty())
      out[field.name] =
          report == nullptr ? boost::json::value() : json_of(std::invoke(field.get, *report));
  });
}

template <Described Report>
boost::json::object to_json(const Report& report) {
  boost::json::object out;
  append_json(out, &report);
  return out;
}

// --- metrics

// Calls visit(metric, get) for each field that is a metric, in page order.
template <Described Report, typename Visit>
void for_each_metric(Visit visit) {
  bool found = true;
  for (int place = 1; found; ++place) {
    found = false;
    for_each_field<Report>([&]<typename Get>(const Field<Get>& field) {
      using Value = FieldValue<Report, Get>;
      if constexpr (std::is_arithmetic_v<Value> || std::same_as<Value, Duration>)
        if (field.metric.place == place) {
          found = true;
          visit(field.metric, [&](const Report& report) {
            const Value value = std::invoke(field.get, report);
            if constexpr (std::same_as<Value, Duration>)
              return base::seconds(value);
            else if constexpr (std::same_as<Value, bool>)
              return value ? 1 : 0;
            else
              return value;
          });
        }
    });
  }
}

}  // namespace tims::io

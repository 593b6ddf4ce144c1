#include "router/io/http/api_question.h"

#include <algorithm>
#include <array>
#include <charconv>

#include <boost/json/object.hpp>
#include <boost/json/serialize.hpp>

#include "router/io/report_json.h"

namespace tims::io {
namespace {

namespace json = boost::json;

// Every argument is a text in a query; these are numbers in JSON.
constexpr std::array<std::string_view, 4> kNumbers{"limit", "since", "type", "wait_ms"};

std::optional<char> from_hex(std::string_view digits) {
  unsigned char byte = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), byte, 16);
  if (error != std::errc{} || end != digits.data() + 2) return std::nullopt;
  return static_cast<char>(byte);
}

std::optional<std::string> decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '+') {
      out += ' ';
    } else if (text[i] == '%') {
      const auto byte = from_hex(text.substr(i + 1, 2));
      if (!byte) return std::nullopt;
      out += *byte;
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

json::value value_of(const std::string& key, const std::string& text) {
  const bool is_number = std::ranges::find(kNumbers, key) != kNumbers.end();
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  // What is no number goes on as a text: the answer will say what is wrong with it.
  if (is_number && error == std::errc{} && end == text.data() + text.size()) return number;
  return json::string(as_utf8(text));
}

}  // namespace

std::optional<std::string> api_question(std::string_view ask, std::string_view query) {
  const auto verb = decoded(ask);
  if (!verb) return std::nullopt;
  json::object question;
  while (!query.empty()) {
    const std::size_t end = std::min(query.find('&'), query.size());
    const std::string_view pair = query.substr(0, end);
    query.remove_prefix(std::min(end + 1, query.size()));
    if (pair.empty()) continue;
    const std::size_t sign = std::min(pair.find('='), pair.size());
    const auto key = decoded(pair.substr(0, sign));
    const auto value = decoded(pair.substr(std::min(sign + 1, pair.size())));
    if (!key || !value) return std::nullopt;
    question[as_utf8(*key)] = value_of(*key, *value);
  }
  question["ask"] = as_utf8(*verb);
  return json::serialize(question);
}

}  // namespace tims::io

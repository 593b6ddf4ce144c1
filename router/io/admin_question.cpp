#include "router/io/admin_question.h"

#include <algorithm>
#include <array>
#include <span>

#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <fmt/format.h>

namespace tims::io {

namespace {

namespace json = boost::json;
using Problem = std::optional<QuestionError>;

constexpr std::int64_t kWaitMaxMs = 30'000;

QuestionError bad_argument(std::string_view name, std::string_view wanted) {
  return {"bad_argument", fmt::format("\"{}\" must be {}", name, wanted)};
}

std::optional<std::int64_t> integer(const json::value& value, std::int64_t min, std::int64_t max) {
  if (!value.is_int64()) return std::nullopt;  // larger ones are uint64, others doubles
  const std::int64_t number = value.get_int64();
  if (number < min || number > max) return std::nullopt;
  return number;
}

std::optional<Address> address(const json::value& value, const AddressWidths& widths) {
  const json::string* text = value.if_string();
  return text == nullptr ? std::nullopt : Address::parse(*text, widths);
}

Problem set_match(Question& question, const json::value& value) {
  const json::string* text = value.if_string();
  const auto pattern =
      text == nullptr ? std::nullopt : AddressPattern::parse(*text, question.widths);
  if (!pattern) return bad_argument("match", "a pattern such as \"Ladar(*/0)\"");
  question.match = *pattern;
  question.pattern = std::string(*text);
  return {};
}
Problem set_to(Question& question, const json::value& value) {
  question.to = address(value, question.widths);
  return question.to ? Problem() : bad_argument("to", "an address such as \"Ladar(3/0)\"");
}
Problem set_from(Question& question, const json::value& value) {
  question.from = address(value, question.widths);
  return question.from ? Problem() : bad_argument("from", "an address such as \"Ladar(3/0)\"");
}
Problem set_type(Question& question, const json::value& value) {
  const auto number = integer(value, -128, 127);
  if (!number) return bad_argument("type", "a number from -128 to 127");
  question.type = static_cast<std::int8_t>(*number);
  return {};
}
Problem set_limit(Question& question, const json::value& value) {
  const auto number = integer(value, 1, kPageItemsMax);
  if (!number) return bad_argument("limit", "a number from 1 to 1000");
  question.limit = static_cast<std::size_t>(*number);
  return {};
}
Problem set_since(Question& question, const json::value& value) {
  const auto number = integer(value, 0, INT64_MAX);
  if (!number) return bad_argument("since", "the number of an event");
  question.since = static_cast<std::uint64_t>(*number);
  return {};
}
Problem set_epoch(Question& question, const json::value& value) {
  const json::string* text = value.if_string();
  if (text == nullptr) return bad_argument("epoch", "what \"epoch\" of the last answer said");
  question.epoch = std::string(*text);
  return {};
}
Problem set_wait(Question& question, const json::value& value) {
  const auto number = integer(value, 0, kWaitMaxMs);
  if (!number) return bad_argument("wait_ms", "a number from 0 to 30000");
  question.wait = std::chrono::milliseconds(*number);
  return {};
}
Problem set_after(Question& question, const json::value& value) {
  const json::string* text = value.if_string();
  if (text == nullptr) return bad_argument("after", "what \"next\" of the last answer said");
  question.after = std::string(*text);
  return {};
}
Problem set_pad(Question& question, const json::value& value) {
  const json::string* text = value.if_string();
  if (text == nullptr) return bad_argument("pad", "a text");
  question.pad = std::string(*text);
  return {};
}

Problem set_link(Question& question, const json::value& value) {
  const json::string* text = value.if_string();
  if (text == nullptr) return bad_argument("link", "the name of the router at its other end");
  question.link = std::string(*text);
  return {};
}
Problem set_action(Question& question, const json::value& value) {
  const json::string* text = value.if_string();
  const bool known = text != nullptr && (*text == "up" || *text == "down" || *text == "reset");
  if (!known) return bad_argument("do", R"("up", "down" or "reset")");
  question.action = std::string(*text);
  return {};
}

std::optional<double> number(const json::value& value, double max) {
  if (!value.is_number()) return std::nullopt;
  const auto number = value.to_number<double>();
  return number >= 0 && number <= max ? std::optional(number) : std::nullopt;
}
template <double link::Faults::*share>
Problem set_share(Question& question, const json::value& value) {
  const auto n = number(value, 1);
  if (!n) return bad_argument("loss, duplicate and reorder", "numbers from 0 to 1");
  question.faults.*share = *n;
  return {};
}
template <Duration link::Faults::*time>
Problem set_time(Question& question, const json::value& value) {
  const auto n = number(value, 60);
  if (!n) return bad_argument("delay_s and jitter_s", "seconds from 0 to 60");
  question.faults.*time = std::chrono::duration_cast<Duration>(std::chrono::duration<double>(*n));
  return {};
}
Problem set_rate(Question& question, const json::value& value) {
  const auto n = number(value, 1e12);
  if (!n) return bad_argument("rate", "bytes a second");
  question.faults.rate = static_cast<std::uint64_t>(*n);
  return {};
}
Problem set_blackout(Question& question, const json::value& value) {
  if (!value.is_bool()) return bad_argument("blackout", "true or false");
  question.faults.blackout = value.get_bool();
  return {};
}

struct Argument {
  std::string_view name;
  Problem (*set)(Question&, const json::value&);
};
constexpr Argument kMatch{"match", set_match};
constexpr Argument kTo{"to", set_to};
constexpr Argument kFrom{"from", set_from};
constexpr Argument kType{"type", set_type};
constexpr Argument kLimit{"limit", set_limit};
constexpr Argument kAfter{"after", set_after};
constexpr Argument kSince{"since", set_since};
constexpr Argument kEpoch{"epoch", set_epoch};
constexpr Argument kWait{"wait_ms", set_wait};
constexpr Argument kPad{"pad", set_pad};
constexpr Argument kLink{"link", set_link};
constexpr Argument kVia{"via", set_link};
constexpr Argument kDo{"do", set_action};
constexpr Argument kLoss{"loss", set_share<&link::Faults::loss>};
constexpr Argument kDuplicate{"duplicate", set_share<&link::Faults::duplicate>};
constexpr Argument kReorder{"reorder", set_share<&link::Faults::reorder>};
constexpr Argument kDelay{"delay_s", set_time<&link::Faults::delay>};
constexpr Argument kJitter{"jitter_s", set_time<&link::Faults::jitter>};
constexpr Argument kRate{"rate", set_rate};
constexpr Argument kBlackout{"blackout", set_blackout};

struct Form {
  std::string_view name;
  Ask ask;
  std::array<Argument, 8> arguments;  // those without a name are not there

  // Null: there is no such argument.
  [[nodiscard]] const Argument* argument(std::string_view key) const {
    const auto* const found = std::ranges::find(arguments, key, &Argument::name);
    return key.empty() || found == arguments.end() ? nullptr : found;
  }
};
constexpr std::array kForms{
    Form{"status", Ask::kStatus, {}},
    Form{"clients", Ask::kClients, {kLimit, kAfter}},
    Form{"routes", Ask::kRoutes, {kMatch, kLimit, kAfter}},
    Form{"route", Ask::kRoute, {kTo, kFrom, kType}},
    Form{"mailboxes", Ask::kMailboxes, {kMatch, kLimit, kAfter}},
    Form{"stats", Ask::kStats, {}},
    Form{"events", Ask::kEvents, {kSince, kEpoch, kWait, kLimit}},
    Form{"config", Ask::kConfig, {}},
    Form{"ping", Ask::kPing, {kPad}},
    Form{"routers", Ask::kRouters, {kLimit, kAfter}},
    Form{"links", Ask::kLinks, {kLink, kLimit, kAfter}},
    Form{"fleet", Ask::kFleet, {}},
    Form{"link", Ask::kLinkDo, {kLink, kDo}},
    Form{"fault",
         Ask::kFault,
         {kLink, kLoss, kDuplicate, kReorder, kDelay, kJitter, kRate, kBlackout}},
    Form{"route_add", Ask::kRouteAdd, {kMatch, kVia}},
    Form{"route_del", Ask::kRouteDelete, {kMatch, kVia}},
};

std::string known_names() {
  std::string names;
  for (const Form& form : kForms) names.append(names.empty() ? "" : ", ").append(form.name);
  return names;
}

// The text is the asker's: a piece of it is enough to recognise it by.
std::string quoted(std::string_view text) { return fmt::format("\"{}\"", text.substr(0, 64)); }

std::variant<Question, QuestionError> read_arguments(const Form& form, const json::object& body,
                                                     const AddressWidths& widths) {
  Question question{.ask = form.ask, .widths = widths};
  for (const auto& [key, value] : body) {
    if (key == "ask") continue;
    const Argument* const argument = form.argument(key);
    if (argument == nullptr)
      return QuestionError{"bad_argument", quoted(form.name) + " has no argument " + quoted(key),
                           "router/io/ADMIN.md lists them"};
    if (auto problem = argument->set(question, value)) return *problem;
  }
  if (question.ask == Ask::kRoute && !question.to)
    return bad_argument("to", "given: the address to look up");
  if (question.ask == Ask::kLinkDo && (question.link.empty() || question.action.empty()))
    return bad_argument("link and do", R"(given: which link, and "up", "down" or "reset")");
  if (acts(question.ask) && question.ask >= Ask::kRouteAdd && question.pattern.empty())
    return bad_argument("match", "given: the addresses that are meant");
  return question;
}

}  // namespace

std::variant<Question, QuestionError> parse_question(std::string_view body,
                                                     const AddressWidths& widths) {
  if (body.size() > kQuestionBytesMax)
    return QuestionError{"bad_json", "a question has at most 64 KiB"};
  json::parse_options options;
  options.max_depth = 4;
  boost::system::error_code error;
  const json::value value = json::parse(body, error, {}, options);
  if (error) return QuestionError{"bad_json", "not JSON: " + error.message()};
  const json::object* object = value.if_object();
  const json::value* ask = object == nullptr ? nullptr : object->if_contains("ask");
  const json::string* name = ask == nullptr ? nullptr : ask->if_string();
  if (name == nullptr)
    return QuestionError{"bad_question", "no \"ask\" in the question",
                         R"({"ask": "status"}, for example)"};
  const auto form = std::ranges::find(kForms, std::string_view(*name), &Form::name);
  if (form == kForms.end())
    return QuestionError{"unknown_question", "this router does not know " + quoted(*name),
                         "it knows " + known_names()};
  return read_arguments(*form, *object, widths);
}

}  // namespace tims::io

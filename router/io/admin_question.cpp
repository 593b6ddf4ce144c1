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

constexpr std::int64_t kWaitMaxMs = 30'000;

// In order of core::LeaseVerb.
constexpr std::array<std::string_view, 4> kLeaseVerbs{"take", "take_over", "renew", "release"};
static_assert(kLeaseVerbs.size() == static_cast<std::size_t>(core::LeaseVerb::kRelease) + 1);

QuestionError bad_argument(std::string_view name, std::string_view wanted) {
  return {"bad_argument", fmt::format("\"{}\" must be {}", name, wanted)};
}

// Larger values are uint64 in JSON, and beyond that double.
template <auto member>
bool set_integer(Question& question, const json::value& value, std::int64_t min, std::int64_t max) {
  if (!value.is_int64() || value.get_int64() < min || value.get_int64() > max) return false;
  using Member = std::remove_cvref_t<decltype(question.*member)>;
  question.*member = static_cast<Member>(value.get_int64());
  return true;
}

// A number from 0 to `max`.
std::optional<double> fraction(const json::value& value, double max) {
  if (!value.is_number()) return std::nullopt;
  const auto number = value.to_number<double>();
  return number >= 0 && number <= max ? std::optional(number) : std::nullopt;
}

template <std::string Question::*member>
bool set_text(Question& question, const json::value& value) {
  const json::string* text = value.if_string();
  if (text != nullptr) question.*member = std::string(*text);
  return text != nullptr;
}

template <std::optional<Address> Question::*member>
bool set_address(Question& question, const json::value& value) {
  const json::string* text = value.if_string();
  if (text != nullptr) question.*member = Address::parse(*text, question.widths);
  return (question.*member).has_value();
}

bool set_match(Question& question, const json::value& value) {
  if (!set_text<&Question::pattern>(question, value)) return false;
  const auto pattern = AddressPattern::parse(question.pattern, question.widths);
  if (pattern) question.match = *pattern;
  return pattern.has_value();
}

bool set_wait(Question& question, const json::value& value) {
  if (!value.is_int64() || value.get_int64() < 0 || value.get_int64() > kWaitMaxMs) return false;
  question.wait = std::chrono::milliseconds(value.get_int64());
  return true;
}

bool set_action(Question& question, const json::value& value) {
  if (!set_text<&Question::action>(question, value)) return false;
  return question.action == "up" || question.action == "down" || question.action == "reset";
}

bool set_stream(Question& question, const json::value& value) {
  const json::string* text = value.if_string();
  if (text == nullptr) return false;
  const auto found = std::ranges::find(core::kStreamKinds, std::string_view(*text),
                                       &core::Label<core::StreamKind>::name);
  if (found == core::kStreamKinds.end()) return false;
  question.stream = found->value;
  return true;
}

bool set_robot(Question& question, const json::value& value) {
  const std::int64_t max = (std::int64_t{1} << question.widths.system) - 1;
  if (!value.is_int64() || value.get_int64() < 0 || value.get_int64() > max) return false;
  question.robot = static_cast<std::uint32_t>(value.get_int64());
  return true;
}

bool set_lease(Question& question, const json::value& value) {
  const json::string* text = value.if_string();
  if (text == nullptr) return false;
  const auto found = std::ranges::find(kLeaseVerbs, std::string_view(*text));
  if (found == kLeaseVerbs.end()) return false;
  question.lease = static_cast<core::LeaseVerb>(found - kLeaseVerbs.begin());
  return true;
}

// A name for users: shorter than the field it is kept in.
bool set_holder(Question& question, const json::value& value) {
  if (!set_text<&Question::holder>(question, value)) return false;
  return !question.holder.empty() &&
         question.holder.size() < decltype(core::DrivingLease::holder)::kBytes;
}

template <double link::Faults::*share>
bool set_share(Question& question, const json::value& value) {
  const auto number = fraction(value, 1);
  if (number) question.faults.*share = *number;
  return number.has_value();
}

template <Duration link::Faults::*time>
bool set_time(Question& question, const json::value& value) {
  const auto number = fraction(value, 60);
  if (number)
    question.faults.*time =
        std::chrono::duration_cast<Duration>(std::chrono::duration<double>(*number));
  return number.has_value();
}

bool set_rate(Question& question, const json::value& value) {
  const auto number = fraction(value, 1e12);
  if (number) question.faults.rate = static_cast<std::uint64_t>(*number);
  return number.has_value();
}

bool set_blackout(Question& question, const json::value& value) {
  if (value.is_bool()) question.faults.blackout = value.get_bool();
  return value.is_bool();
}

struct Argument {
  std::string_view name{};
  bool (*set)(Question&, const json::value&) = nullptr;
  std::string_view wanted{};  // description of valid values
  std::string_view shown{};   // name used in the error message, if not the argument's own
};
constexpr std::string_view kAddressWanted = R"x(an address such as "Ladar(3/0)")x";
constexpr std::string_view kLinkWanted = "the name of the router at its other end";
constexpr std::string_view kShares = "loss, duplicate and reorder";
constexpr std::string_view kSharesWanted = "numbers from 0 to 1";
constexpr std::string_view kTimes = "delay_s and jitter_s";
constexpr std::string_view kTimesWanted = "seconds from 0 to 60";

constexpr Argument kMatch{"match", set_match, R"x(a pattern such as "Ladar(*/0)")x"};
constexpr Argument kTo{"to", set_address<&Question::to>, kAddressWanted};
constexpr Argument kFrom{"from", set_address<&Question::from>, kAddressWanted};
constexpr Argument kType{
    "type",
    [](Question& q, const json::value& v) { return set_integer<&Question::type>(q, v, -128, 127); },
    "a number from -128 to 127"};
constexpr Argument kLimit{"limit",
                          [](Question& q, const json::value& v) {
                            return set_integer<&Question::limit>(q, v, 1, kPageItemsMax);
                          },
                          "a number from 1 to 1000"};
constexpr Argument kAfter{"after", set_text<&Question::after>, R"(the "next" of the last answer)"};
constexpr Argument kSince{"since",
                          [](Question& q, const json::value& v) {
                            return set_integer<&Question::since>(q, v, 0, INT64_MAX);
                          },
                          "the number of an event"};
constexpr Argument kEpoch{"epoch", set_text<&Question::epoch>, R"(the "epoch" of the last answer)"};
constexpr Argument kWait{"wait_ms", set_wait, "a number from 0 to 30000"};
constexpr Argument kPad{"pad", set_text<&Question::pad>, "a text"};
constexpr Argument kLink{"link", set_text<&Question::link>, kLinkWanted};
constexpr Argument kVia{"via", set_text<&Question::link>, kLinkWanted, "link"};
constexpr Argument kDo{"do", set_action, R"("up", "down" or "reset")"};
constexpr Argument kLoss{"loss", set_share<&link::Faults::loss>, kSharesWanted, kShares};
constexpr Argument kDuplicate{"duplicate", set_share<&link::Faults::duplicate>, kSharesWanted,
                              kShares};
constexpr Argument kReorder{"reorder", set_share<&link::Faults::reorder>, kSharesWanted, kShares};
constexpr Argument kDelay{"delay_s", set_time<&link::Faults::delay>, kTimesWanted, kTimes};
constexpr Argument kJitter{"jitter_s", set_time<&link::Faults::jitter>, kTimesWanted, kTimes};
constexpr Argument kRate{"rate", set_rate, "bytes a second"};
constexpr Argument kOf{"of", set_address<&Question::of>, kAddressWanted};
constexpr Argument kStream{"stream", set_stream, R"("data", "status" or "parameters")"};
constexpr Argument kRobot{"robot", set_robot, "the number of a robot, its system"};
constexpr Argument kLeaseDo{"do", set_lease, R"("take", "take_over", "renew" or "release")"};
constexpr Argument kHolder{"name", set_holder, "a name of 1 to 31 bytes, as others shall see it"};
constexpr Argument kStick{"stick", set_address<&Question::stick>,
                          R"x(the address of a joystick such as "Joystick(3/0)")x"};
constexpr Argument kMailbox{"mailbox", set_address<&Question::mailbox>, kAddressWanted};
constexpr Argument kRight{
    "right",
    [](Question& q, const json::value& v) {
      return set_text<&Question::right>(q, v) &&
             (q.right == "look" || q.right == "drive" || q.right == "configure");
    },
    R"("look", "drive" or "configure")"};
constexpr Argument kWho{"who", set_text<&Question::who>,
                        R"(identities such as "user:guest" or "uid:1000, gid:100")"};
constexpr Argument kWhat{
    "what", set_text<&Question::what>,
    R"(a type of messages such as "move", or "look", "change", "agree", "login")"};
constexpr Argument kPriority{"priority",
                             [](Question& q, const json::value& v) {
                               return set_integer<&Question::priority>(q, v, 0, 255);
                             },
                             "a number from 0 to 255"};
constexpr Argument kAudit{"audit",
                          [](Question& q, const json::value& v) {
                            if (v.is_bool()) q.audit = v.get_bool();
                            return v.is_bool();
                          },
                          "true or false"};
constexpr Argument kBearer{"bearer",
                           [](Question& q, const json::value& v) {
                             if (v.is_bool()) q.bearer = v.get_bool();
                             return v.is_bool();
                           },
                           "true or false"};
constexpr Argument kBlackout{"blackout", set_blackout, "true or false"};

struct Form {
  std::string_view name;
  Ask ask;
  std::array<Argument, 8> arguments;  // unused entries have no name

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
    Form{"route", Ask::kRoute, {kTo, kFrom, kType, kWhat}},
    Form{"mailboxes", Ask::kMailboxes, {kMatch, kLimit, kAfter}},
    Form{"stats", Ask::kStats, {}},
    Form{"events", Ask::kEvents, {kSince, kEpoch, kWait, kLimit, kAudit}},
    Form{"config", Ask::kConfig, {}},
    Form{"ping", Ask::kPing, {kPad}},
    Form{"routers", Ask::kRouters, {kLimit, kAfter}},
    Form{"links", Ask::kLinks, {kLink, kLimit, kAfter}},
    Form{"fleet", Ask::kFleet, {}},
    Form{"newest", Ask::kNewest, {kOf, kStream, kMatch, kLimit, kAfter}},
    Form{"streams", Ask::kStreams, {kTo, kMatch, kLimit, kAfter}},
    Form{"leases", Ask::kLeases, {kLimit, kAfter}},
    Form{"lease", Ask::kLease, {kRobot, kLeaseDo, kHolder, kStick, kMailbox}},
    Form{"rules", Ask::kRules, {kLimit, kAfter}},
    Form{"verdict", Ask::kVerdict, {kWho, kTo, kWhat, kPriority}},
    Form{"login", Ask::kLogin, {kRight, kBearer}},
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

// The text comes from the client: a prefix is enough to identify it.
std::string quoted(std::string_view text) { return fmt::format("\"{}\"", text.substr(0, 64)); }

// Of a question to an agent; empty: it cannot be understood.
std::string agent_ask(std::string_view body) {
  boost::system::error_code error;
  const json::value value = json::parse(body, error);
  const json::object* object = error ? nullptr : value.if_object();
  const json::value* ask = object == nullptr ? nullptr : object->if_contains("ask");
  const json::string* name = ask == nullptr ? nullptr : ask->if_string();
  return name == nullptr ? std::string() : std::string(*name);
}

std::variant<Question, QuestionError> read_arguments(const Form& form, const json::object& body,
                                                     const AddressWidths& widths) {
  Question question{.ask = form.ask, .widths = widths};
  for (const auto& [key, value] : body) {
    if (key == "ask") continue;
    const Argument* const argument = form.argument(key);
    if (argument == nullptr)
      return QuestionError{"bad_argument", quoted(form.name) + " has no argument " + quoted(key),
                           "router/io/ADMIN.md lists them"};
    if (!argument->set(question, value))
      return bad_argument(argument->shown.empty() ? argument->name : argument->shown,
                          argument->wanted);
  }
  if (question.ask == Ask::kRoute && !question.to)
    return bad_argument("to", "given: the address to look up");
  if (question.ask == Ask::kVerdict &&
      (question.who.empty() || !question.to || question.what.empty()))
    return bad_argument("who, to and what",
                        "given: who sends which type of messages to which address");
  const bool takes =
      question.lease == core::LeaseVerb::kTake || question.lease == core::LeaseVerb::kTakeOver;
  if (question.ask == Ask::kLease &&
      (!question.robot || !body.contains("do") || (takes && question.holder.empty())))
    return bad_argument(
        "robot, do and name",
        R"(given: which robot, "take", "take_over", "renew" or "release", and who)");
  if (question.ask == Ask::kLinkDo && (question.link.empty() || question.action.empty()))
    return bad_argument("link and do", R"(given: which link, and "up", "down" or "reset")");
  if (question.ask >= Ask::kRouteAdd && question.pattern.empty())
    return bad_argument("match", "given: the addresses of the route");
  return question;
}

}  // namespace

std::string_view name(Ask ask) { return std::ranges::find(kForms, ask, &Form::ask)->name; }

bool is_agent_agreeing(std::string_view body) { return agent_ask(body) == "conf_peer"; }

bool is_agent_reading(std::string_view body) {
  constexpr std::array<std::string_view, 9> kReads{
      "conf_list",  "conf_get",     "conf_options",    "conf_describe", "conf_state",
      "conf_check", "conf_history", "conf_generation", "conf_fleet"};
  return std::ranges::find(kReads, agent_ask(body)) != kReads.end();
}

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

#include "tests/bench/plan.h"

#include <charconv>
#include <concepts>

namespace tims::bench {
namespace {

// The list of all keys; calls `visit(key, member)` for each.
template <typename P, typename Visit>
void each_member(P& plan, Visit visit) {
  visit("--role", plan.role);
  visit("--link", plan.link);
  visit("--folder", plan.folder);
  visit("--socket", plan.socket);
  visit("--endpoint", plan.endpoint);
  visit("--host", plan.host);
  visit("--payload", plan.payload);
  visit("--window", plan.window);
  visit("--subscribers", plan.subscribers);
  visit("--index", plan.index);
  visit("--pair", plan.pair);
  visit("--priority", plan.priority);
  visit("--count", plan.count);
  visit("--nanoseconds", plan.seconds);
  visit("--every", plan.every);
}

std::string text_of(const std::string& value) { return value; }
std::string text_of(std::integral auto value) { return std::to_string(value); }
std::string text_of(Duration value) { return std::to_string(value.count()); }

bool read(const std::string& text, std::string& value) {
  value = text;
  return true;
}
bool read(const std::string& text, std::integral auto& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}
bool read(const std::string& text, Duration& value) {
  Duration::rep count = 0;
  if (!read(text, count)) return false;
  value = Duration(count);
  return true;
}

}  // namespace

std::vector<std::string> to_arguments(const Plan& plan) {
  std::vector<std::string> arguments;
  each_member(plan, [&](const char* key, const auto& value) {
    const std::string text = text_of(value);
    if (text.empty()) return;
    arguments.emplace_back(key);
    arguments.push_back(text);
  });
  return arguments;
}

Result<Plan> parse_plan(std::span<const std::string> arguments) {
  Plan plan;
  for (std::size_t i = 0; i + 1 < arguments.size(); i += 2) {
    bool taken = false;
    each_member(plan, [&](const char* key, auto& value) {
      if (arguments[i] == key) taken = read(arguments[i + 1], value);
    });
    if (!taken) {
      return Error(Errc::kInvalidArgument, "role: " + arguments[i] + " " + arguments[i + 1]);
    }
  }
  return plan;
}

}  // namespace tims::bench

#include "tools/sim/quality.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <vector>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "tools/cli/failure.h"

namespace timsctl::sim {

namespace {

using tims::Errc;
using tims::Error;
using tims::Result;
using namespace std::chrono_literals;

constexpr std::array<std::string_view, 6> kKeys = {"loss",  "duplicate", "reorder",
                                                   "delay", "jitter",    "rate"};
constexpr tims::Duration kDelayMax = 60s;

Error bad(std::string detail) { return {Errc::kInvalidArgument, std::move(detail)}; }

std::optional<double> number_before(std::string_view text, std::string_view& unit) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) return std::nullopt;
  unit = text.substr(static_cast<std::size_t>(end - text.data()));
  return value;
}

// "1%", "0.01"
Result<double> parse_share(std::string_view text) {
  std::string_view unit;
  auto value = number_before(text, unit);
  if (value && unit == "%") *value /= 100;
  const bool is_share = value && *value >= 0 && *value <= 1;
  if (!is_share || (!unit.empty() && unit != "%"))
    return bad(fmt::format(R"(requires a share such as "1%", not "{}")", text));
  return *value;
}

// "50Mbit" (per second), "6MB" (bytes per second), "0": no limit.
Result<std::uint64_t> parse_rate(std::string_view text) {
  struct Unit {
    std::string_view name;
    double bits;
  };
  constexpr std::array kUnits = {Unit{"bit", 1},      Unit{"kbit", 1e3}, Unit{"Mbit", 1e6},
                                 Unit{"Gbit", 1e9},   Unit{"B", 8},      Unit{"kB", 8e3},
                                 Unit{"MB", 8e6},     Unit{"GB", 8e9},   Unit{"KiB", 8 * 1024},
                                 Unit{"MiB", 8 << 20}};
  std::string_view name;
  const auto value = number_before(text, name);
  if (value && *value == 0 && name.empty()) return std::uint64_t{0};
  const auto* const unit = std::ranges::find(kUnits, name, &Unit::name);
  if (!value || unit == kUnits.end())
    return bad(
        fmt::format(R"(requires a rate per second such as "50Mbit" or "6MB", not "{}")", text));
  const double bits = *value * unit->bits;
  const bool in_range = bits >= 8'000 && bits <= 1e12;
  if (!in_range)
    return bad(fmt::format("requires a rate from 8kbit to 1000Gbit, not \"{}\"", text));
  return static_cast<std::uint64_t>(bits);
}

Result<tims::Duration> parse_delay(std::string_view text) {
  const auto value = base::parse_duration(text);
  if (!value || *value < tims::Duration{} || *value > kDelayMax)
    return bad(fmt::format(R"(requires a duration up to 60s such as "20ms", not "{}")", text));
  return *value;
}

template <typename T>
Result<void> store(T& member, const Result<T>& value) {
  if (!value) return value.error();
  member = *value;
  return {};
}

enum class Direction : std::uint8_t { kBoth, kUp, kDown };

Result<Direction> parse_direction(std::string_view text) {
  if (text == "both") return Direction::kBoth;
  if (text == "up") return Direction::kUp;
  if (text == "down") return Direction::kDown;
  return bad(
      fmt::format("direction requires up (towards the base), down or both, not \"{}\"", text));
}

constexpr std::string_view kDirectionKey = "direction=";

Result<Direction> direction_of(std::span<const std::string> arguments) {
  Direction direction = Direction::kBoth;
  for (const std::string& argument : arguments) {
    if (!argument.starts_with(kDirectionKey)) continue;
    const auto parsed = parse_direction(std::string_view(argument).substr(kDirectionKey.size()));
    if (!parsed) return parsed.error();
    direction = *parsed;
  }
  return direction;
}

Error unknown_fault(std::string_view argument, const Profiles& profiles) {
  std::vector<std::string_view> known = {"cut", "heal", "off"};
  for (const auto& [name, quality] : profiles) known.push_back(name);
  const auto near = base::nearest(argument, known);
  if (near) return bad(fmt::format("\"{}\" is not a fault; did you mean {}?", argument, *near));
  return bad(fmt::format("\"{}\" is not a fault; known: {}, and key=value with the keys {}",
                         argument, fmt::join(known, ", "), fmt::join(kKeys, ", ")));
}

Result<void> set_fault(Quality& quality, std::string_view argument, const Profiles& profiles) {
  const auto profile = profiles.find(argument);
  if (profile != profiles.end()) {
    quality = profile->second;
    return {};
  }
  const std::size_t equals = argument.find('=');
  if (equals == std::string_view::npos) return unknown_fault(argument, profiles);
  const std::string_view key = argument.substr(0, equals);
  const auto set = set_key(quality, key, argument.substr(equals + 1));
  return set ? set : bad(fmt::format("{} {}", key, set.error().detail()));
}

std::string share_text(double share) { return fmt::format("{:g}%", share * 100); }
std::string delay_text(tims::Duration delay) {
  return fmt::format("{:g}ms", std::chrono::duration<double, std::milli>(delay).count());
}

}  // namespace

Profiles built_in_profiles() {
  return {{"cable", {}},
          {"wifi", {.loss = 0.001, .delay = 2ms, .jitter = 3ms, .rate_bits = 50'000'000}},
          {"corridor", {.loss = 0.05, .delay = 15ms, .jitter = 40ms, .rate_bits = 2'000'000}},
          {"lte", {.loss = 0.003, .delay = 40ms, .jitter = 20ms, .rate_bits = 10'000'000}},
          {"blackout", {.blackout = true}}};
}

std::span<const std::string_view> quality_keys() { return kKeys; }

Result<void> set_key(Quality& quality, std::string_view key, std::string_view value) {
  if (key == "loss") return store(quality.loss, parse_share(value));
  if (key == "duplicate") return store(quality.duplicate, parse_share(value));
  if (key == "reorder") return store(quality.reorder, parse_share(value));
  if (key == "delay") return store(quality.delay, parse_delay(value));
  if (key == "jitter") return store(quality.jitter, parse_delay(value));
  if (key == "rate") return store(quality.rate_bits, parse_rate(value));
  const auto near = base::nearest(key, kKeys);
  if (near) return bad(fmt::format("is not a property of a line; did you mean {}?", *near));
  return bad(fmt::format("is not a property of a line; known: {}", fmt::join(kKeys, ", ")));
}

Result<LineState> changed(const LineState& now, const LineState& own,
                          std::span<const std::string> arguments, const Profiles& profiles) {
  const auto direction = direction_of(arguments);
  if (!direction) return direction.error();
  if (arguments.empty()) return bad("requires a profile, cut, heal or key=value");
  LineState state = now;
  const bool up = *direction != Direction::kDown;
  const bool down = *direction != Direction::kUp;
  for (const std::string& argument : arguments) {
    if (argument.starts_with(kDirectionKey)) continue;
    if (argument == "cut") {
      if (*direction != Direction::kBoth)
        return bad("cut affects both directions; use blackout for one direction");
      state.cut = true;
    } else if (argument == "heal" || argument == "off") {
      if (up) state.up = own.up;
      if (down) state.down = own.down;
      state.cut = own.cut;
    } else {
      for (Quality* quality : {up ? &state.up : nullptr, down ? &state.down : nullptr}) {
        if (quality == nullptr) continue;
        if (const auto set = set_fault(*quality, argument, profiles); !set) return set.error();
      }
    }
  }
  return state;
}

std::string rate_text(std::uint64_t bits) {
  const auto count = static_cast<double>(bits);
  if (bits >= 1'000'000'000) return fmt::format("{:g}Gbit", count / 1e9);
  if (bits >= 1'000'000) return fmt::format("{:g}Mbit", count / 1e6);
  return fmt::format("{:g}kbit", count / 1e3);
}

std::string to_string(const Quality& quality) {
  if (quality.blackout) return "blackout";
  std::string text;
  const auto add = [&](std::string_view key, const std::string& value) {
    text += fmt::format("{}{} {}", text.empty() ? "" : " ", key, value);
  };
  if (quality.loss > 0) add("loss", share_text(quality.loss));
  if (quality.duplicate > 0) add("duplicate", share_text(quality.duplicate));
  if (quality.reorder > 0) add("reorder", share_text(quality.reorder));
  if (quality.delay > tims::Duration{}) add("delay", delay_text(quality.delay));
  if (quality.jitter > tims::Duration{}) add("jitter", delay_text(quality.jitter));
  if (quality.rate_bits > 0) add("rate", rate_text(quality.rate_bits));
  return text.empty() ? "perfect" : text;
}

std::string to_string(const LineState& state) {
  if (state.cut) return "cut";
  if (state.up == state.down) return to_string(state.up);
  return fmt::format("up: {}, down: {}", to_string(state.up), to_string(state.down));
}

}  // namespace timsctl::sim

#include "components/devices/camera/parameter_file.h"

#include <cmath>
#include <string>

#include "base/text.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;
using tims::base::parse_number;

constexpr std::string_view kBlanks = " \t\r";

std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.size(), line.find_first_not_of(kBlanks)));
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

Pixels<i32> number_as(const Pixels<i32>&, float value) { return static_cast<i32>(value); }
template <typename Number>
Number number_as(const Number&, float value) {
  return Number(value);
}

// Calls `set` with what the name stands for. Returns false for other names.
template <typename Set>
bool with(std::string_view name, CameraParamData& all, Set set) {
  const std::size_t digit = name.size() == 2 && name[1] >= '1' && name[1] <= '9'
                                ? static_cast<std::size_t>(name[1] - '1')
                                : all.coordinateRotation.size();
  if (name == "f") return set(all.f), true;
  if (name == "fx") return set(all.fx), true;
  if (name == "fy") return set(all.fy), true;
  if (name == "sx") return set(all.sx), true;
  if (name == "sy") return set(all.sy), true;
  if (name == "dx") return set(all.dx), true;
  if (name == "dy") return set(all.dy), true;
  if (name == "k1") return set(all.k1), true;
  if (name == "k2") return set(all.k2), true;
  if (name == "p1") return set(all.p1), true;
  if (name == "p2") return set(all.p2), true;
  if (name == "e0") return set(all.e0), true;
  if (name == "n0") return set(all.n0), true;
  if (name == "calibration_width") return set(all.calibration_width), true;
  if (name == "calibration_height") return set(all.calibration_height), true;
  if (name.starts_with('r') && digit < all.coordinateRotation.size())
    return set(all.coordinateRotation.at(digit)), true;
  if (name.starts_with('t') && digit < all.coordinateTranslation.size())
    return set(all.coordinateTranslation.at(digit)), true;
  return false;
}

}  // namespace

Result<void> add_parameters(std::string_view text, CameraParamData& parameters) {
  for (int number = 1; !text.empty(); ++number) {
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    const std::string_view name = take_word(line);
    const std::string_view value = take_word(line);
    bool is_good = true;
    with(name, parameters, [&](auto& parameter) {
      const auto parsed = parse_number<float>(value);
      is_good = parsed && std::isfinite(*parsed) && std::abs(*parsed) <= 1e9F;
      if (is_good) parameter = number_as(parameter, *parsed);
    });
    if (!is_good)
      return Error(Errc::kMalformed,
                   "line " + std::to_string(number) + ": " + tims::base::in_quotes(name) +
                       " must be followed by a number, not " + tims::base::in_quotes(value));
  }
  return {};
}

}  // namespace rack::device

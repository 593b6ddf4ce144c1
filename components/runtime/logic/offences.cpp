#include "components/runtime/logic/offences.h"

#include <algorithm>

namespace rack {
namespace {

constexpr std::string_view kCalledBy = " < ";

// The innards of std::vector and the like say less than who uses them.
bool is_of_library(std::string_view name) {
  const std::size_t at = name.find("std::");
  return at != std::string_view::npos && at < name.find('<');
}

}  // namespace

bool OffencePlaces::add(Offence offence, std::string_view text) {
  const auto known = std::ranges::find_if(
      places_, [&](const Place& place) { return place.offence == offence && place.text == text; });
  if (known != places_.end()) {
    ++known->count;
    return false;
  }
  if (places_.size() == kMax) return false;
  places_.push_back({offence, std::string(text), 1});
  return true;
}

std::vector<OffencePlaces::Place> OffencePlaces::worst(std::size_t max) const {
  std::vector<Place> sorted = places_;
  std::ranges::stable_sort(sorted, std::ranges::greater(), &Place::count);
  if (sorted.size() > max) sorted.resize(max);
  return sorted;
}

std::string place_text(std::span<const std::string> functions, std::string_view outermost,
                       std::size_t size_max) {
  std::string text;
  for (const std::string& function : functions) {
    const std::string_view name = without_parameters(function);
    if (name == outermost) break;
    if (!text.empty() && is_of_library(name)) continue;
    const std::size_t more = name.size() + (text.empty() ? 0 : kCalledBy.size());
    if (!text.empty() && text.size() + more > size_max) break;
    if (!text.empty()) text += kCalledBy;
    text += name;
  }
  text.resize(std::min(text.size(), size_max));
  return text;
}

std::string_view without_parameters(std::string_view function) {
  // "(anonymous namespace)" and "operator()" are parts of names: the last pair is the parameters.
  const std::size_t last = function.rfind(')');
  if (last == std::string_view::npos) return function;
  int open = 0;
  for (std::size_t i = last + 1; i-- > 0;) {
    if (function[i] == ')') ++open;
    if (function[i] == '(' && --open == 0) {
      const bool names = i == 0 || function[i - 1] == ':' || function[i - 1] == ' ';
      return names ? function : function.substr(0, i);
    }
  }
  return function;
}

}  // namespace rack

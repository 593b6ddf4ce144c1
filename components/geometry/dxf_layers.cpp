#include "components/geometry/dxf_layers.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/text.h"

namespace rack {

DxfLayers::DxfLayers(std::string_view choice) {
  while (!choice.empty()) {
    const auto end = choice.find(',');
    std::string_view text = tims::base::trimmed(choice.substr(0, end));
    choice.remove_prefix(end == std::string_view::npos ? choice.size() : end + 1);
    const bool is_excluded = text.starts_with('-');
    if (is_excluded) text = tims::base::trimmed(text.substr(1));
    if (!text.empty())
      patterns_.push_back({.text = tims::base::lower(text), .is_excluded = is_excluded});
  }
}

std::int32_t DxfLayers::index(std::string_view name) {
  const std::string key = tims::base::lower(name);
  const auto found = indices_.find(key);
  if (found != indices_.end()) return found->second;
  const auto next = static_cast<std::int32_t>(layers_.size());
  if (layers_.size() >= kLayersMax) {
    if (layers_.size() == kLayersMax)
      layers_.push_back({.name = "of more than 10000", .is_chosen = is_chosen("")});
    return static_cast<std::int32_t>(kLayersMax);
  }
  indices_[key] = next;
  layers_.push_back(
      {.name = std::string(name),
       .number = tims::base::parse_number<std::int32_t>(tims::base::trimmed(name)).value_or(0),
       .is_chosen = is_chosen(key)});
  return next;
}

bool DxfLayers::is_chosen(const std::string& name) {
  bool has_wanted = false;
  bool is_wanted = false;
  bool is_excluded = false;
  for (Pattern& pattern : patterns_) {
    const bool is_match = matches_pattern(name, pattern.text);
    pattern.has_layer = pattern.has_layer || is_match;
    has_wanted = has_wanted || !pattern.is_excluded;
    (pattern.is_excluded ? is_excluded : is_wanted) |= is_match;
  }
  return (is_wanted || !has_wanted) && !is_excluded;
}

void DxfLayers::hide(std::string_view name) { at(index(name)).is_hidden = true; }

bool DxfLayers::shows(std::int32_t index) {
  Layer& layer = at(index);
  if (layer.is_hidden) ++layer.hidden;
  return !layer.is_hidden;
}

bool DxfLayers::takes(std::int32_t index) {
  Layer& layer = at(index);
  if (!layer.is_chosen) ++layer.not_chosen;
  return layer.is_chosen;
}

void DxfLayers::report(DxfRemarks& remarks) const {
  for (const Pattern& pattern : patterns_)
    if (!pattern.has_layer)
      remarks.add(0, fmt::format("no layer is named \"{}\"; there are {}",
                                 DxfRemarks::named(pattern.text), names()));
  for (const Layer& layer : layers_) {
    const std::string name = DxfRemarks::named(layer.name);
    if (layer.hidden > 0)
      remarks.add(0, fmt::format("layer \"{}\" is off or frozen: {} entities are left out", name,
                                 layer.hidden));
    if (layer.not_chosen > 0)
      remarks.add(0, fmt::format("layer \"{}\" is not chosen: {} lines are left out", name,
                                 layer.not_chosen));
  }
}

std::string DxfLayers::names() const {
  constexpr std::size_t kNamesMax = 12;
  if (layers_.empty()) return "none";
  std::string text;
  for (std::size_t i = 0; i < std::min(layers_.size(), kNamesMax); ++i)
    text += fmt::format("{}\"{}\"", i == 0 ? "" : ", ", DxfRemarks::named(layers_[i].name));
  return layers_.size() <= kNamesMax
             ? text
             : fmt::format("{} and {} more", text, layers_.size() - kNamesMax);
}

bool matches_pattern(std::string_view name, std::string_view pattern) {
  std::size_t n = 0;
  std::size_t p = 0;
  // After the last *: where it stands, and how far the name was matched by it.
  std::size_t star = std::string_view::npos;
  std::size_t taken = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      taken = n;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n])) {
      ++p;
      ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++taken;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

}  // namespace rack

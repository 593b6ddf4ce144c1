// What is to be said about a drawing, in the order of its lines.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.h"
#include "components/geometry/dxf.h"

namespace rack {

class DxfRemarks {
 public:
  // Line 0: about the whole drawing.
  void add(std::size_t line, std::string text) {
    if (remarks_.size() < DxfDrawing::kRemarksMax) remarks_.emplace_back(line, std::move(text));
  }
  // About an entity.
  void add(std::size_t line, std::string_view type, std::string_view why) {
    add(line, named(type, kTypeMax) + " " + std::string(why));
  }

  // Names in a drawing may be of any length and contain anything.
  static std::string named(std::string_view name, std::size_t most = kNameMax) {
    return tims::base::printable(name.substr(0, most));
  }

  [[nodiscard]] std::vector<std::string> texts() const {
    auto sorted = remarks_;
    std::ranges::stable_sort(sorted, {}, &std::pair<std::size_t, std::string>::first);
    std::vector<std::string> texts;
    texts.reserve(sorted.size());
    for (const auto& [line, text] : sorted)
      texts.push_back(line == 0 ? text : "line " + std::to_string(line) + ": " + text);
    return texts;
  }

 private:
  static constexpr std::size_t kTypeMax = 20;
  static constexpr std::size_t kNameMax = 60;

  std::vector<std::pair<std::size_t, std::string>> remarks_;
};

}  // namespace rack

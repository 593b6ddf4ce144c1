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
    auto& remarks = line == 0 ? of_drawing_ : of_lines_;
    if (remarks.size() < (line == 0 ? kOfDrawingMax : DxfDrawing::kRemarksMax))
      remarks.emplace_back(line, std::move(text));
    else
      ++others_;
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
    auto sorted = of_lines_;
    std::ranges::stable_sort(sorted, {}, &Remark::first);
    sorted.insert(sorted.begin(), of_drawing_.begin(), of_drawing_.end());
    std::vector<std::string> texts;
    texts.reserve(sorted.size());
    for (const auto& [line, text] : sorted)
      texts.push_back(line == 0 ? text : "line " + std::to_string(line) + ": " + text);
    if (others_ == 0 && texts.size() <= DxfDrawing::kRemarksMax) return texts;
    const std::size_t kept = std::min(texts.size(), DxfDrawing::kRemarksMax - 1);
    const std::size_t more = others_ + texts.size() - kept;
    texts.resize(kept);
    texts.push_back("and " + std::to_string(more) + " more");
    return texts;
  }

 private:
  static constexpr std::size_t kTypeMax = 20;
  static constexpr std::size_t kNameMax = 60;

  // Remarks about the whole drawing are kept when it has many damaged parts.
  static constexpr std::size_t kOfDrawingMax = 12;

  using Remark = std::pair<std::size_t, std::string>;
  std::vector<Remark> of_drawing_;
  std::vector<Remark> of_lines_;
  std::size_t others_ = 0;  // that were not kept
};

}  // namespace rack

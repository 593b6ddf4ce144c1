// The layers of a drawing: which of them are walls. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "components/geometry/dxf_remarks.h"

namespace rack {

class DxfLayers {
 public:
  static constexpr std::size_t kLayersMax = 10'000;

  // `choice`: see PlanPlacement::layers. Without one, all layers that are visible.
  explicit DxfLayers(std::string_view choice = {});

  // The index of the layer with this name; upper and lower case are the same. The layers above the
  // limit share one index.
  std::int32_t index(std::string_view name);
  // The number in its name; 0: it is not a number.
  [[nodiscard]] std::int32_t number(std::int32_t index) const { return at(index).number; }

  // Marks a layer as off or frozen.
  void hide(std::string_view name);
  // Whether an entity on this layer can be seen; counts those that cannot.
  bool shows(std::int32_t index);
  // Whether lines on this layer are walls; counts those that are not.
  bool takes(std::int32_t index);

  // What was left out, and patterns without a layer.
  void report(DxfRemarks& remarks) const;

 private:
  struct Layer {
    std::string name;
    std::int32_t number = 0;
    bool is_chosen = true;
    bool is_hidden = false;
    std::size_t hidden = 0;      // entities
    std::size_t not_chosen = 0;  // lines
  };
  struct Pattern {
    std::string text;
    bool is_excluded = false;
    bool has_layer = false;
  };
  [[nodiscard]] const Layer& at(std::int32_t index) const {
    return layers_[static_cast<std::size_t>(index)];
  }
  Layer& at(std::int32_t index) { return layers_[static_cast<std::size_t>(index)]; }
  bool is_chosen(const std::string& name);
  [[nodiscard]] std::string names() const;

  std::vector<Pattern> patterns_;
  std::vector<Layer> layers_;
  std::map<std::string, std::int32_t, std::less<>> indices_;  // by name in lower case
};

// Whether a name is matched by a pattern with * (any characters) and ? (one character).
bool matches_pattern(std::string_view name, std::string_view pattern);

}  // namespace rack

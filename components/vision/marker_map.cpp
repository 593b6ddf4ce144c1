#include "components/vision/marker_map.h"

#include <algorithm>
#include <array>

#include <fmt/core.h>

#include "components/geometry/pose.h"

namespace rack::vision {

namespace {

using Node = tims::base::TomlNode;
using Reader = tims::base::TomlReader;

struct Known {
  Family family;
  std::string_view name;
  int ids;
};
constexpr std::array<Known, 3> kFamilies = {{{Family::kTag36h11, "tag36h11", 587},
                                             {Family::kTag25h9, "tag25h9", 35},
                                             {Family::kTag16h5, "tag16h5", 30}}};

constexpr double kFarthest = 1e7;  // mm
constexpr double kHighest = 1e5;
constexpr double kSmallest = 10;
constexpr double kLargest = 5000;

const Known& known(Family family) { return *std::ranges::find(kFamilies, family, &Known::family); }

class MarkerReader {
 public:
  MarkerFile read(const tims::base::TextFile& text) {
    const tims::base::TomlTree tree = tims::base::parse_toml(text);
    for (const auto& problem : tree.problems) reader_.add(problem);
    // Defaults first, wherever they are in the file.
    reader_.table(tree.root, "a marker map",
                  {{"family", [&](const Node& n) { family(n, defaults_.family); }},
                   {"size", [&](const Node& n) { size(n, defaults_.size); }},
                   {"height", [&](const Node& n) { height(n, defaults_.height); }},
                   {"marker", [](const Node&) {}}});
    for (const Node& node : tree.root.children)
      if (node.key == "marker") reader_.tables(node, [&](const Node& n) { marker(n); });
    file_.problems = reader_.problems();
    return std::move(file_);
  }

 private:
  void family(const Node& node, Family& out) {
    std::string name;
    if (!reader_.text(node, name)) return;
    if (const auto found = family_of(name)) {
      out = *found;
      return;
    }
    std::vector<std::string> names;
    for (const Known& each : kFamilies) names.emplace_back(each.name);
    reader_.unknown(node.at_value, "family of markers", name, names);
  }
  void size(const Node& node, double& out) { reader_.real(node, kSmallest, kLargest, out); }
  void height(const Node& node, double& out) { reader_.real(node, 0, kHighest, out); }

  void at(const Node& node, Marker& marker) {
    if (node.form != Node::Form::kArray || node.children.size() != 3)
      return reader_.refuse(node, "must be [x, y, direction]: mm, mm, degrees");
    reader_.real(node.children[0], -kFarthest, kFarthest, marker.at.x);
    reader_.real(node.children[1], -kFarthest, kFarthest, marker.at.y);
    double angle = 0;
    reader_.real(node.children[2], -360, 360, angle);
    marker.rho = heading(radians(angle));
  }

  void marker(const Node& node) {
    Marker marker = defaults_;
    std::int64_t id = -1;
    bool has_place = false;
    reader_.table(node, "a marker",
                  {{"family", [&](const Node& n) { this->family(n, marker.family); }},
                   {"id", [&](const Node& n) { reader_.number(n, 0, 1'000'000, id); }},
                   {"at",
                    [&](const Node& n) {
                      has_place = true;
                      at(n, marker);
                    }},
                   {"height", [&](const Node& n) { height(n, marker.height); }},
                   {"size", [&](const Node& n) { size(n, marker.size); }}});
    if (!has_place) return add(node, "a marker needs `at = [x, y, direction]`");
    const Known& family = known(marker.family);
    if (id < 0 || id >= family.ids)
      return add(node, fmt::format("a marker of {} needs an `id` from 0 to {}", family.name,
                                   family.ids - 1));
    marker.id = static_cast<int>(id);
    if (std::ranges::any_of(file_.markers, [&](const Marker& m) { return m.is_like(marker); }))
      return add(node, "there is a marker that looks the same");
    file_.markers.push_back(std::move(marker));
  }

  void add(const Node& node, std::string problem) {
    reader_.add({node.at_value, std::move(problem)});
  }

  Reader reader_;
  Marker defaults_;
  MarkerFile file_;
};

}  // namespace

std::string_view name_of(Family family) { return known(family).name; }
int ids_of(Family family) { return known(family).ids; }

std::optional<Family> family_of(std::string_view name) {
  const auto* found = std::ranges::find(kFamilies, name, &Known::name);
  return found == kFamilies.end() ? std::nullopt : std::optional(found->family);
}

MarkerFile read_marker_map(const tims::base::TextFile& file) { return MarkerReader().read(file); }

}  // namespace rack::vision

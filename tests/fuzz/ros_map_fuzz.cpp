// Any description and picture is refused with a reason, or yields a map with the stated number of
// cells, its walls as lines, and a likelihood field that can be queried anywhere.
#include "components/localisation/likelihood_field.h"
#include "components/localisation/outlines.h"
#include "components/localisation/ros_map.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using tims::fuzz::require;
  namespace localisation = rack::localisation;
  const std::string_view text = tims::fuzz::Input(data, size).text();
  // The picture follows after the description.
  const auto cut = text.find("\n--\n");
  const auto info = localisation::read_ros_yaml(text.substr(0, cut));
  require(info.ok() || !info.error().detail().empty());
  if (!info || cut == std::string_view::npos) return 0;
  const auto picture = rack::pictures::read_grey(text.substr(cut + 4));
  if (!picture) {
    require(!picture.error().detail().empty());
    return 0;
  }
  const auto map = localisation::grid_of(*info, *picture);
  require(map.cells.size() ==
          static_cast<std::size_t>(map.rows) * static_cast<std::size_t>(map.columns));
  const auto walls = localisation::outlines(map, 1000);
  require(walls.ok() || !walls.error().detail().empty());
  require(!walls || (!walls->lines.empty() && walls->lines.size() <= 1000));
  const auto field = localisation::LikelihoodField::of(map, {});
  require(field.ok() == (map.count(localisation::Cell::kOccupied) > 0 &&
                         map.count(localisation::Cell::kFree) > 0));
  if (!field) return 0;
  for (const float at : {0.0F, -1e9F, 1e9F, 1e30F})
    require(field->distance(static_cast<double>(at), 0) >= 0);
  return 0;
}

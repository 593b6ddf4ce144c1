#include "tools/evaluation/drives/scene_file.h"

#include <filesystem>

#include "components/position/map_file.h"
#include "components/position/map_picture.h"
#include "components/world/core/world_file.h"
#include "os/file.h"

namespace rack::drives {

tims::Result<Scene> read_scene(const std::string& world, const std::string& plan) {
  const std::filesystem::path path(world);
  auto text = tims::os::read_file(path, localisation::kMapBytesMax);
  if (!text) return text.error();
  auto file = world::read_world(
      {world, std::move(*text)},
      [&](const std::string& name) {
        return tims::os::read_file(path.parent_path() / name, localisation::kMapBytesMax);
      },
      navigation::read_map_picture);
  if (!file.problems.empty())
    return tims::Error(tims::Errc::kInvalidArgument, file.problems.front().to_string());
  auto known = navigation::load_plan(plan, {.scale = 0, .scale_otherwise = 1000});
  if (!known) return known.error();
  return Scene{
      .name = path.stem(), .world = std::move(file.description), .plan = std::move(*known)};
}

}  // namespace rack::drives

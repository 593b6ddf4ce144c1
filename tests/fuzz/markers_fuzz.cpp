// Maps of markers; and pictures in which markers are looked for: a letter for the width, and the
// pixels.
#include <cmath>

#include "components/vision/marker_finder.h"
#include "components/vision/marker_map.h"
#include "components/vision/marker_pose.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using tims::fuzz::require;
namespace vision = rack::vision;

vision::CameraGeometry camera(int width, int height) {
  rack::CameraParamData parameters;
  parameters.calibration_width = width;
  parameters.calibration_height = height;
  parameters.fx = parameters.fy = static_cast<float>(width);
  return *vision::CameraGeometry::make(parameters, width, height, {.z = -500});
}

void look_at(std::string_view pixels, int width) {
  const int height = static_cast<int>(pixels.size()) / width;
  vision::MarkerFinder finder({vision::Family::kTag36h11, vision::Family::kTag16h5});
  const auto found = finder.find(
      {width, height, {reinterpret_cast<const std::uint8_t*>(pixels.data()), pixels.size()}});
  require(found.ok());
  for (const vision::Sighting& seen : *found) {
    require(seen.id >= 0 && seen.id < vision::ids_of(seen.family));
    if (const auto poses = vision::poses_of(seen, 160, camera(width, height)))
      require(std::isfinite(poses->front().rho));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = tims::fuzz::Input(data, size).text();
  if (!text.empty() && text.front() >= 'A' && text.front() <= 'Z') {  // 8, 16, 24 ... pixels wide
    const int width = 8 * (text.front() - 'A' + 1);
    if (text.size() > static_cast<std::size_t>(width)) look_at(text.substr(1), width);
    return 0;
  }
  const vision::MarkerFile file = vision::read_marker_map({"markers.toml", std::string(text)});
  for (const auto& problem : file.problems) require(!problem.text.empty());
  for (const vision::Marker& marker : file.markers) {
    require(marker.id >= 0 && marker.id < vision::ids_of(marker.family));
    require(marker.size >= 10 && marker.size <= 5000);
    require(std::isfinite(marker.at.x + marker.at.y + marker.rho + marker.height));
  }
  return 0;
}

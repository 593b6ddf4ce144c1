#include "components/sim/map_scanner.h"

#include <cerrno>
#include <fstream>
#include <iterator>

namespace rack::sim {
namespace {

constexpr std::streamoff kFileMax = 64 << 20;  // a drawing of such a size is none of a floor

Result<std::string> read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file || file.tellg() < 0)
    return tims::Error(tims::Errc::kSystem, std::generic_category().message(errno));
  if (file.tellg() > kFileMax) return tims::Error(tims::Errc::kTooBig, "it is larger than 64 MB");
  file.seekg(0);
  return std::string(std::istreambuf_iterator<char>(file), {});
}

Result<DxfDrawing> read_drawing(const std::string& path) {
  const auto text = read_file(path);
  if (!text) return text.error();
  return read_dxf(*text);
}

}  // namespace

Result<FloorMap> load_map(const std::string& path, double scale, double offset_x, double offset_y,
                          TextLog& log) {
  const auto drawing = read_drawing(path);
  if (!drawing)
    return tims::Error(drawing.error().code(), "map " + path + ": " + drawing.error().detail());
  for (const std::string& skipped : drawing->skipped) log.warning("%s, %s", path, skipped);
  const FloorMap map(*drawing, scale, offset_x, offset_y);
  log.info("%s has %u features", path, static_cast<unsigned>(map.size()));
  return map;
}

}  // namespace rack::sim

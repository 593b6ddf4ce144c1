#include "components/position/map_file.h"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "components/localisation/ros_map.h"

namespace rack::navigation {

namespace {

constexpr std::uintmax_t kFileMax = 512U << 20U;

tims::Error in_file(const std::string& path, const tims::Error& error) {
  return {error.code(), path + ": " + error.detail()};
}

}  // namespace

tims::Result<std::string> read_file(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) return tims::Error(tims::Errc::kSystem, path + ": " + error.message());
  if (size > kFileMax) return tims::Error(tims::Errc::kTooBig, path + ": larger than 512 MB");
  std::ifstream file(path, std::ios::binary);
  if (!file)
    return tims::Error(tims::Errc::kSystem, path + ": " + std::generic_category().message(errno));
  return std::string(std::istreambuf_iterator<char>(file), {});
}

tims::Result<void> write_file(const std::string& path, std::string_view text) {
  const std::string fresh = path + ".new";
  std::ofstream file(fresh, std::ios::binary | std::ios::trunc);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file)
    return tims::Error(tims::Errc::kSystem, fresh + ": " + std::generic_category().message(errno));
  std::error_code error;
  std::filesystem::rename(fresh, path, error);
  if (error) return tims::Error(tims::Errc::kSystem, path + ": " + error.message());
  return {};
}

tims::Result<localisation::GridMap> load_map(const std::string& path,
                                             const PlanPlacement& placement) {
  const auto text = read_file(path);
  if (!text) return text.error();
  if (!path.ends_with(".yaml") && !path.ends_with(".yml")) {
    const auto drawing = read_dxf(*text);
    if (!drawing) return in_file(path, drawing.error());
    auto map = localisation::read_map(*drawing, placement.scale, placement.offset_x,
                                      placement.offset_y, placement.resolution);
    if (!map) return in_file(path, map.error());
    return map;
  }
  const auto info = localisation::read_ros_yaml(*text);
  if (!info) return in_file(path, info.error());
  const std::string image = std::filesystem::path(path).parent_path() / info->image;
  const auto picture = read_file(image);
  if (!picture) return picture.error();
  auto map = localisation::read_ros_map(*info, *picture);
  if (!map) return in_file(image, map.error());
  return map;
}

}  // namespace rack::navigation

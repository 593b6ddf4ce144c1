// marker-print: AprilTags as files to print, in their true size.
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "base/text.h"
#include "components/position/map_file.h"
#include "components/vision/marker_picture.h"
#include "tools/cli/argument_parser.h"
#include "tools/cli/failure.h"

namespace rack::marker_print {
namespace {

using timsctl::Exit;
using timsctl::Failure;
using vision::Marker;

struct Wanted {
  std::vector<std::string> ids{};
  std::string family = "tag36h11";
  double size = 160;
  std::string folder = ".";
};

constexpr const char* kAbout =
    "Writes AprilTags as files to print, NAME-ID.svg, one for each ID.\n\n"
    "Print them at 100 % (not \"fit to page\") on matt paper, and measure the black square: its "
    "side is\n"
    "the size for the map of markers (components/vision/README.md). The white border belongs to "
    "the "
    "marker.";
constexpr const char* kExits =
    "Exit status: 0 done, 2 wrong command line, 5 not written.\n\n"
    "Example: marker-print 0 1 2 --size 160 --output markers";

// A cell is one unit; lines of black cells are single rectangles, which printers draw without gaps.
std::string svg_of(const Marker& marker, const vision::MarkerPicture& picture) {
  const double whole = marker.size * picture.whole;
  const double cell = whole / picture.side;
  constexpr double kCaption = 8;  // mm below the marker
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.3f}mm\" height=\"{1:.3f}mm\" "
      "viewBox=\"0 0 {0:.3f} {1:.3f}\" shape-rendering=\"crispEdges\">\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      whole, whole + kCaption);
  for (int y = 0; y < picture.side; ++y)
    for (int x = 0; x < picture.side;) {
      const auto is_black = [&](int at) {
        return at < picture.side &&
               picture.cells.at(static_cast<std::size_t>(y * picture.side + at)) < 128;
      };
      int end = x;
      while (is_black(end)) ++end;
      if (end > x)
        svg += fmt::format("<rect x=\"{:.3f}\" y=\"{:.3f}\" width=\"{:.3f}\" height=\"{:.3f}\"/>\n",
                           x * cell, y * cell, (end - x) * cell, cell);
      x = end + 1;
    }
  svg += fmt::format(
      "<text x=\"{:.3f}\" y=\"{:.3f}\" font-family=\"sans-serif\" font-size=\"4\" "
      "text-anchor=\"middle\">{} {}, {} mm</text>\n</svg>\n",
      whole / 2, whole + 5, vision::name_of(marker.family), marker.id, marker.size);
  return svg;
}

Marker marker_of(const Wanted& wanted, const std::string& id) {
  const auto family = vision::family_of(wanted.family);
  if (!family)
    throw timsctl::usage_error(wanted.family + ": no such family", "tag36h11, tag25h9 or tag16h5");
  const auto number = tims::base::parse_number<int>(id);
  if (!number || *number < 0 || *number >= vision::ids_of(*family))
    throw timsctl::usage_error(fmt::format("{}: {} has the markers 0 to {}", id, wanted.family,
                                           vision::ids_of(*family) - 1));
  return {.family = *family, .id = *number, .size = wanted.size};
}

Exit print(const Wanted& wanted) {
  if (wanted.ids.empty()) throw timsctl::usage_error("no ID is given", "marker-print 0 1 2");
  std::vector<Marker> markers;
  for (const std::string& id : wanted.ids) markers.push_back(marker_of(wanted, id));
  std::error_code ignored;  // writing reports it
  std::filesystem::create_directories(wanted.folder, ignored);
  for (const Marker& marker : markers) {
    const auto picture = vision::picture_of(marker);
    if (!picture) throw timsctl::usage_error(picture.error().detail());
    const std::string file =
        std::filesystem::path(wanted.folder) / fmt::format("{}-{}.svg", wanted.family, marker.id);
    if (const auto written = navigation::write_file(file, svg_of(marker, *picture)); !written)
      throw Failure(Exit::kDenied, "not_written", written.error().detail());
    fmt::print("{}\n", file);
  }
  return Exit::kDone;
}

}  // namespace
}  // namespace rack::marker_print

int main(int argc, char** argv) {
  rack::marker_print::Wanted wanted;
  timsctl::ArgumentParser parser("marker-print", rack::marker_print::kAbout,
                                 rack::marker_print::kExits);
  parser.arguments("ID", wanted.ids, "numbers of the markers");
  parser.option("--family", wanted.family, "tag36h11, tag25h9 or tag16h5");
  parser.option("--size", wanted.size, "side of the black square [mm]", {10, 5000});
  parser.option("--output", wanted.folder, "folder for the files");
  return parser.run(argc, argv, [&] { return rack::marker_print::print(wanted); });
}

// timsctl camera: pictures of cameras in files, also with what was recognised in them.
#include "rack/proxies/camera.h"

#include <cmath>

#include <fmt/format.h>

#include "components/devices/camera/picture.h"
#include "components/files/loaded_library.h"
#include "components/files/whole_file.h"
#include "components/pictures/png_file.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/component_client.h"
#include "tools/timsctl/recognised_picture.h"

namespace timsctl {

namespace {

namespace mode = rack::camera_mode;
using rack::pictures::CameraPicture;
using rack::pictures::LabelledBox;
using rack::pictures::PixelLayout;

bool is_jpeg_name(std::string_view file) {
  return file.ends_with(".jpg") || file.ends_with(".jpeg");
}

void check_name(const std::string& file, bool has_boxes) {
  if (has_boxes && !file.ends_with(".png"))
    throw usage_error(file + ": pictures with objects are PNG; the name must end in .png");
  if (!is_jpeg_name(file) && !file.ends_with(".png"))
    throw usage_error(file + ": the name must end in .png or .jpg");
}

rack::pictures::EncodePng load_encoder() {
  const auto encoder = rack::load_function<rack::pictures::EncodePng>(
      rack::kPicturesLibrary, rack::pictures::kEncodePngSymbol);
  if (encoder) return *encoder;
  throw Failure(Exit::kNo, "no_opencv", fmt::format("PNG needs {}", encoder.error().detail()),
                "or set mode=jpeg and save a .jpg");
}

CameraPicture content_of(const rack::CameraData& picture) {
  if (picture.mode == mode::kJpeg) return {.jpeg = picture.image};
  const auto layout = picture.mode == mode::kDisparity ? PixelLayout::kBig16
                                                       : rack::device::layout_of_mode(picture.mode);
  if (!layout)
    throw Failure(
        Exit::kNo, "other_mode",
        fmt::format("pictures of mode {} cannot be saved", static_cast<unsigned>(picture.mode)),
        "set mode to jpeg, rgb24, yuv422, mono8, mono16, range or disparity");
  return {.pixels = {.layout = *layout,
                     .size = {picture.width.raw(), picture.height.raw()},
                     .bytes = picture.image}};
}

// JPEG is written as the camera sent it.
std::vector<std::byte> file_of(const rack::CameraData& picture, const std::string& name,
                               std::span<const LabelledBox> boxes) {
  if (is_jpeg_name(name)) {
    if (picture.mode != mode::kJpeg)
      throw usage_error(name + ": this camera sends pixels; the name must end in .png");
    return {picture.image.begin(), picture.image.end()};
  }
  tims::Result<std::vector<std::byte>> png = std::vector<std::byte>();
  load_encoder()(content_of(picture), boxes, png);
  if (!png) throw Failure(Exit::kNo, "bad_picture", png.error().detail());
  return std::move(*png);
}

// Objects of other sensors have no area in a picture.
std::vector<LabelledBox> boxes_of(const rack::ObjRecogData& data) {
  std::vector<LabelledBox> boxes;
  for (const rack::ObjRecogObject& object : data.objects) {
    const rack::ImageRect& area = object.imageArea;
    if (area.width <= 0 || area.height <= 0) continue;
    const double distance = std::hypot(object.pos.x.raw(), object.pos.y.raw()) / 1000;
    boxes.push_back({.left = area.x,
                     .top = area.y,
                     .width = area.width,
                     .height = area.height,
                     .label = fmt::format("{}: {:.1f} m", object.objectId, distance)});
  }
  return boxes;
}

rack::CameraData newest_picture(ComponentClient& client, tims::Address camera) {
  const auto newest = client.newest_data(camera);
  if (!newest)
    throw Failure(Exit::kNo, "no_picture", client.name_of(camera) + " has no picture",
                  "timsctl component on " + client.name_of(camera));
  return value_or_fail(rack::decode<rack::CameraData>(newest->view()), client.name_of(camera));
}

}  // namespace

Exit camera_save(Context& context) {
  const std::string& file = context.options.arguments[1];
  const std::string& recogniser = context.options.objects;
  check_name(file, !recogniser.empty());
  ComponentClient client(context, {.address = {}, .body_max = rack::kCameraBytesMax + 1024});
  const tims::Address camera = client.address(context.options.arguments[0]);
  RecognisedPicture shown;
  if (recogniser.empty())
    shown.picture = newest_picture(client, camera);
  else
    shown = recognised_picture(client, camera, client.address(recogniser), context.options.timeout);
  const rack::CameraData& picture = shown.picture;
  const std::vector<LabelledBox> boxes = boxes_of(shown.objects);

  const auto content = file_of(picture, file, boxes);
  const std::string_view text(reinterpret_cast<const char*>(content.data()), content.size());
  if (auto written = rack::write_file(file, text); !written)
    throw Failure(Exit::kDenied, "not_written", written.error().detail());
  json::object answer{
      {"schema", "tims/camera_saved/1"}, {"file", file},
      {"width", picture.width.raw()},    {"height", picture.height.raw()},
      {"bytes", content.size()},         {"recording_time_ms", picture.recordingTime.raw()}};
  if (!recogniser.empty()) answer["objects"] = boxes.size();
  context.out.write(answer, [&] {
    const std::string objects = recogniser.empty() ? ""
                                                   : fmt::format(", {} object{}", boxes.size(),
                                                                 boxes.size() == 1 ? "" : "s");
    return fmt::format("{}: {} x {} pixels{}\n", file, static_cast<unsigned>(picture.width.raw()),
                       static_cast<unsigned>(picture.height.raw()), objects);
  });
  return Exit::kDone;
}

}  // namespace timsctl

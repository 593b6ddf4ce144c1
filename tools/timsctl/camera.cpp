// timsctl camera: pictures of cameras in files.
#include "rack/proxies/camera.h"

#include <optional>

#include <fmt/format.h>

#include "components/files/whole_file.h"
#include "components/pictures/png_file.h"
#include "components/pictures/loaded_library.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/component_client.h"

namespace timsctl {

namespace {

namespace mode = rack::camera_mode;
using rack::pictures::RawForm;

std::optional<RawForm> form_of(rack::u16 camera_mode) {
  switch (camera_mode) {
    case mode::kMono8:
      return RawForm::kGrey;
    case mode::kMono16:
    case mode::kRange:
    case mode::kDisparity:
      return RawForm::kGrey16;
    case mode::kRgb24:
      return RawForm::kRgb;
    case mode::kYuv422:
      return RawForm::kUyvy;
    default:
      return std::nullopt;
  }
}

rack::pictures::EncodePng load_encoder() {
  const auto encoder = rack::pictures::load_function<rack::pictures::EncodePng>(
      rack::pictures::kPicturesLibrary, rack::pictures::kEncodePngSymbol);
  if (encoder) return *encoder;
  throw Failure(Exit::kNo, "no_opencv", fmt::format("PNG needs {}", encoder.error().detail()),
                "or set mode=jpeg and save a .jpg");
}

// What the file contains. JPEG is written as the camera sent it.
std::vector<std::byte> content_of(const rack::CameraData& picture, const std::string& file) {
  const auto image = std::span<const std::byte>(picture.image);
  if (picture.mode == mode::kJpeg) {
    if (!file.ends_with(".jpg") && !file.ends_with(".jpeg"))
      throw usage_error(file + ": this camera sends JPEG; the name must end in .jpg");
    return {image.begin(), image.end()};
  }
  if (!file.ends_with(".png"))
    throw usage_error(file + ": this camera sends pixels; the name must end in .png");
  const auto form = form_of(picture.mode);
  if (!form)
    throw Failure(
        Exit::kNo, "other_mode",
        fmt::format("pictures of mode {} cannot be saved", static_cast<unsigned>(picture.mode)),
        "set mode to jpeg, rgb24, yuv422, mono8, mono16, range or disparity");
  tims::Result<std::vector<std::byte>> png = std::vector<std::byte>();
  load_encoder()({*form, static_cast<std::int32_t>(picture.width.raw()),
                  static_cast<std::int32_t>(picture.height.raw()), image},
                 png);
  if (!png) throw Failure(Exit::kNo, "bad_picture", png.error().detail());
  return std::move(*png);
}

}  // namespace

Exit camera_save(Context& context) {
  const auto& arguments = context.options.arguments;
  ComponentClient client(context, {.address = {}, .body_max = rack::kCameraBytesMax + 1024});
  const tims::Address camera = need_address(arguments[0], client.widths());
  const auto newest = client.newest_data(camera);
  if (!newest)
    throw Failure(Exit::kNo, "no_picture", client.name_of(camera) + " has no picture",
                  "timsctl component on " + client.name_of(camera));
  const auto picture =
      value_or_fail(rack::decode<rack::CameraData>(newest->view()), client.name_of(camera));
  const std::string& file = arguments[1];
  const auto content = content_of(picture, file);
  const std::string_view text(reinterpret_cast<const char*>(content.data()), content.size());
  if (auto written = rack::write_file(file, text); !written)
    throw Failure(Exit::kDenied, "not_written", written.error().detail());
  const json::object answer{
      {"schema", "tims/camera_saved/1"}, {"file", file},
      {"width", picture.width.raw()},    {"height", picture.height.raw()},
      {"bytes", content.size()},         {"recording_time_ms", picture.recordingTime.raw()}};
  context.out.write(answer, [&] {
    return fmt::format("{}: {} x {} pixels\n", file, static_cast<unsigned>(picture.width.raw()),
                       static_cast<unsigned>(picture.height.raw()));
  });
  return Exit::kDone;
}

}  // namespace timsctl

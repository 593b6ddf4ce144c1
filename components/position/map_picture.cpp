#include "components/position/map_picture.h"

#include <string>

#include "components/files/loaded_library.h"

namespace rack::navigation {

namespace {

tims::Result<pictures::ReadGrey> load_decoder() {
  auto decoder = load_function<pictures::ReadGrey>(kPicturesLibrary, pictures::kReadGreySymbol);
  if (decoder) return decoder;
  return tims::Error(tims::Errc::kSystem,
                     "pictures of maps need " + decoder.error().detail() + ", or use a plan (DXF)");
}

}  // namespace

tims::Result<pictures::GreyPicture> read_map_picture(std::string_view bytes) {
  static const auto decoder = load_decoder();
  if (!decoder) return decoder.error();
  tims::Result<pictures::GreyPicture> picture = pictures::GreyPicture{};
  (*decoder)(bytes, picture);
  return picture;
}

}  // namespace rack::navigation

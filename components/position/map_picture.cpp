#include "components/position/map_picture.h"

#include <string>

#include "components/position/pictures_library.h"

namespace rack::navigation {

namespace {

tims::Result<pictures::ReadGrey> load_decoder() {
  const auto function = function_of_pictures(pictures::kReadGreySymbol);
  if (function) return reinterpret_cast<pictures::ReadGrey>(*function);
  return tims::Error(tims::Errc::kSystem, "pictures of maps need " + function.error().detail() +
                                              ", or use a plan (DXF)");
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

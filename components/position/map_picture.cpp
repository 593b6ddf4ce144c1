#include "components/position/map_picture.h"

#include <string>

#include <dlfcn.h>

namespace rack::navigation {

namespace {

tims::Result<pictures::ReadGrey> load_decoder() {
  void* const library = ::dlopen(RACK_PICTURES_LIBRARY, RTLD_NOW | RTLD_LOCAL);
  void* const function = library == nullptr ? nullptr : ::dlsym(library, pictures::kReadGreySymbol);
  if (function != nullptr) return reinterpret_cast<pictures::ReadGrey>(function);
  const char* const reason = ::dlerror();
  return tims::Error(tims::Errc::kSystem,
                     std::string("pictures of maps need OpenCV: ") +
                         (reason == nullptr ? RACK_PICTURES_LIBRARY : reason) +
                         "; build with -DRACK_WITH_OPENCV=ON, or use a plan (DXF)");
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

#include "components/position/pictures_library.h"

#include <string>

#include <dlfcn.h>

namespace rack::navigation {

tims::Result<PicturesFunction> function_of_pictures(const char* name) {
  void* const library = ::dlopen(RACK_PICTURES_LIBRARY, RTLD_NOW | RTLD_LOCAL);
  void* const function = library == nullptr ? nullptr : ::dlsym(library, name);
  if (function != nullptr) return reinterpret_cast<PicturesFunction>(function);
  const char* const reason = ::dlerror();
  return tims::Error(tims::Errc::kSystem, std::string("OpenCV: ") +
                                              (reason == nullptr ? RACK_PICTURES_LIBRARY : reason) +
                                              "; build with -DRACK_WITH_OPENCV=ON");
}

}  // namespace rack::navigation

#include "components/files/loaded_library.h"

#include <string>

#include <dlfcn.h>

namespace rack {

tims::Result<AnyFunction> load_function(const char* library, const char* symbol) {
  const std::string file = std::string("lib") + library + "-" RACK_VERSION ".so";
  void* const loaded = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const function = loaded == nullptr ? nullptr : ::dlsym(loaded, symbol);
  if (function != nullptr) return reinterpret_cast<AnyFunction>(function);
  const char* const reason = ::dlerror();  // NOLINT(concurrency-mt-unsafe): of this thread
  return tims::Error(tims::Errc::kSystem,
                     "OpenCV: " + (reason == nullptr ? file : reason) +
                         "; install tims-pictures, or build with -DRACK_WITH_OPENCV=ON");
}

}  // namespace rack

// Loads the parts of this project that need OpenCV's decoders and encoders, when a program needs
// them (components/pictures/README.md says why). They stay loaded.
#pragma once

#include "tims/result.h"

namespace rack {

inline constexpr const char* kPicturesLibrary = "rack-pictures";         // maps, plots, PNG
inline constexpr const char* kWorldCameraLibrary = "rack-world-camera";  // components/world

using AnyFunction = void (*)();

// A function of the library by its name. Error kSystem: "OpenCV: REASON; ..." with what helps, for
// a caller that puts before it what needs OpenCV.
tims::Result<AnyFunction> load_function(const char* library, const char* symbol);

// The same for a caller that knows the type of the function.
template <typename Function>
tims::Result<Function> load_function(const char* library, const char* symbol) {
  const auto function = load_function(library, symbol);
  if (!function) return function.error();
  return reinterpret_cast<Function>(*function);
}

}  // namespace rack

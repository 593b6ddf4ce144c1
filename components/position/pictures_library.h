// Loads librack-pictures, the part of this project that needs OpenCV's decoders and encoders
// (components/pictures/grey_picture.h says why). It stays loaded.
#pragma once

#include "tims/result.h"

namespace rack::navigation {

using PicturesFunction = void (*)();

// A function of the library by its name; the caller knows its type. Error kSystem: "OpenCV: REASON;
// build with -DRACK_WITH_OPENCV=ON", to be continued with what does without it.
tims::Result<PicturesFunction> function_of_pictures(const char* name);

}  // namespace rack::navigation

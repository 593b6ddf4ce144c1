// Pictures of maps, decoded by librack-pictures, which is loaded when it is needed for the first
// time and stays loaded (grey_picture.h says why).
#pragma once

#include <string_view>

#include "components/pictures/grey_picture.h"

namespace rack::navigation {

// PGM or PNG. kMalformed: what is wrong with the picture. kSystem: the library is missing, for
// example because this was built without OpenCV.
tims::Result<pictures::GreyPicture> read_map_picture(std::string_view bytes);

}  // namespace rack::navigation

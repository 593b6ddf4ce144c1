// A family of AprilTags of libapriltag, with its end.
#pragma once

#include <memory>

#include <apriltag/apriltag.h>

#include "components/vision/marker_map.h"

namespace rack::vision {

using TagFamily = std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)>;

TagFamily make_tag_family(Family family);

}  // namespace rack::vision

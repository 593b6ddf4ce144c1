#include "components/vision/tag_family.h"

extern "C" {
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>
}

namespace rack::vision {

TagFamily make_tag_family(Family family) {
  switch (family) {
    case Family::kTag36h11:
      return {tag36h11_create(), tag36h11_destroy};
    case Family::kTag25h9:
      return {tag25h9_create(), tag25h9_destroy};
    case Family::kTag16h5:
      return {tag16h5_create(), tag16h5_destroy};
  }
  return {nullptr, nullptr};
}

}  // namespace rack::vision

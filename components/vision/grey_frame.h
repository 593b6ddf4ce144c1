// Pictures of cameras in grey, for what looks for shapes in them.
#pragma once

#include <cstddef>
#include <vector>

#include "components/pictures/jpeg.h"
#include "components/vision/grey_view.h"
#include "rack/proxies/camera.h"
#include "tims/result.h"

namespace rack::vision {

// Keeps its buffers between pictures. Not thread-safe.
class GreyFrame {
 public:
  // From mono8, mono16, rgb24, yuv422 or jpeg. kInvalidArgument: another mode. kMalformed: fewer
  // bytes than the size requires. The view is valid until the next call.
  tims::Result<GreyView> take(const CameraData& picture);

 private:
  pictures::Jpeg jpeg_;
  pictures::PixelConverter converter_;
  std::vector<std::byte> pixels_;
};

}  // namespace rack::vision

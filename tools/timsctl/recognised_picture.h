// A picture of a camera, and what an ObjRecog component has recognised in it.
#pragma once

#include "rack/proxies/camera.h"
#include "rack/proxies/obj_recog.h"
#include "tools/timsctl/component_client.h"

namespace timsctl {

struct RecognisedPicture {
  rack::CameraData picture;
  rack::ObjRecogData objects;
};

// Recognition takes time, while the camera goes on: the last pictures are kept until the objects of
// one of them arrive. Throws Failure: one of them is off, or there is no such picture in time.
RecognisedPicture recognised_picture(ComponentClient& client, tims::Address camera,
                                     tims::Address recogniser, tims::Duration patience);

}  // namespace timsctl

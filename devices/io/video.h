// Cameras of Linux (V4L2): frames in memory that is shared with the driver, with the time at which
// they were taken. Webcams, depth cameras, grabbers.
//
//   v4l:/dev/video0?size=640x480&format=MJPG,YUYV&rate=30
//
// format: the first of them that the camera has; size and rate: the nearest it has. What arrives is
// said in core/video_frame.h. Who is slow gets the newest frame. What is sent with the id of a
// control sets it.
#pragma once

#include "devices/io/transport.h"

namespace rack::device {

tims::Result<std::unique_ptr<Transport>> open_video(const DeviceAddress& address);

// Whether the camera has that size in one of the formats, although somebody uses it now; the error
// says what it has.
tims::Result<void> check_video(const DeviceAddress& address);

}  // namespace rack::device

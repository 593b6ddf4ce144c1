// Pins of the computer itself, by the kernel's character device for GPIO (Linux 5.10 and later).
//
//   gpio:/dev/gpiochip0?in=17,27&out=22&bias=pull-up
//
// An arrival is the level of one line: its offset is the id, one byte is 0 or 1. All of them come
// once at the beginning, inputs whenever they change, with the kernel's time. What is sent with the
// id of an output sets it. gpioinfo shows which line is which.
#pragma once

#include "devices/io/transport.h"

namespace rack::device {

tims::Result<std::unique_ptr<Transport>> open_gpio(const DeviceAddress& address);

}  // namespace rack::device

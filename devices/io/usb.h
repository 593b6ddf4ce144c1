// Devices at USB without a driver of the kernel: bytes by bulk transfers of libusb.
//
//   usb:15d1:0000            usb:15d1:0000/H0712345   (vendor:product, serial number)
//
// The first interface that has a bulk endpoint for each direction is used; a driver of the kernel
// that holds it is sent away while we are there.
#pragma once

#include "devices/io/transport.h"

namespace rack::device {

tims::Result<std::unique_ptr<Transport>> open_usb(const DeviceAddress& address);

}  // namespace rack::device

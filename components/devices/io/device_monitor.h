// Reports that a device was plugged in or unplugged.
#pragma once

#include "components/devices/io/udev_library.h"
#include "tims/result.h"

namespace rack::device {

// With udevd, events come when udev has made its links and set permissions, otherwise straight from
// the kernel. Some containers receive neither: also poll host_devices() periodically.
class DeviceMonitor {
 public:
  static tims::Result<DeviceMonitor> open();

  // Readable when a device of the list (udev_subsystems()) was plugged in or unplugged. A device
  // that is several of the kernel's causes several events.
  [[nodiscard]] int descriptor() const;
  // Does not wait.
  void take_events();

 private:
  explicit DeviceMonitor(Udev<udev_monitor> monitor) : monitor_(std::move(monitor)) {}

  Udev<udev_monitor> monitor_;
};

}  // namespace rack::device

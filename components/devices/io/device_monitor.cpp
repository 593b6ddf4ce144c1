#include "components/devices/io/device_monitor.h"

#include <cerrno>

#include "components/devices/known/udev_device.h"
#include "os/file.h"

namespace rack::device {

tims::Result<DeviceMonitor> DeviceMonitor::open() {
  const Udev<udev> context(::udev_new());
  Udev<udev_monitor> monitor(
      context ? ::udev_monitor_new_from_netlink(context.get(), has_udevd() ? "udev" : "kernel")
              : nullptr);
  if (!monitor) return tims::os::system_error("cannot receive device events");
  for (const char* subsystem : udev_subsystems())
    ::udev_monitor_filter_add_match_subsystem_devtype(monitor.get(), subsystem, nullptr);
  if (const int result = ::udev_monitor_enable_receiving(monitor.get()); result < 0) {
    errno = -result;
    return tims::os::system_error("cannot receive device events");
  }
  return DeviceMonitor(std::move(monitor));
}

int DeviceMonitor::descriptor() const { return ::udev_monitor_get_fd(monitor_.get()); }

void DeviceMonitor::take_events() {
  while (Udev<udev_device>(::udev_monitor_receive_device(monitor_.get()))) {
  }
}

}  // namespace rack::device

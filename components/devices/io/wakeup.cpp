#include "rack/devices/wakeup.h"

#include <unistd.h>

#include "os/wakeup.h"

namespace rack::device {

Wakeup::~Wakeup() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

tims::Result<void> Wakeup::open() {
  if (descriptor_ >= 0) return {};
  auto made = tims::os::make_event_fd();
  if (!made) return made.error();
  descriptor_ = made->release();
  return {};
}

void Wakeup::signal() const {
  if (descriptor_ >= 0) tims::os::signal_event_fd(descriptor_);
}

void Wakeup::drain() const {
  if (descriptor_ >= 0) tims::os::drain_event_fd(descriptor_);
}

}  // namespace rack::device

// A joystick with buttons (specification, section 9.8).
#pragma once

#include "rack/proxies/proxy.h"

namespace rack {

// Each axis from -100 to 100: x forward, y right, z sideways. The angles are not used.
struct JoystickAxes {
  Percent<i32> x = 0;
  Percent<i32> y = 0;
  Percent<i32> z = 0;
  Radians<f32> phi = 0;
  Radians<f32> psi = 0;
  Radians<f32> rho = 0;
};

struct JoystickData {
  TimeStamp recordingTime = 0;  // 0 from the original's software joystick
  JoystickAxes position = {};
  i32 buttons = 0;  // bit n: button n is pressed
};

// The original's software joystick sends messages of type 0 (OK) instead of DATA until get_data()
// was called once: call it before get_cont_data().
class JoystickProxy : public DataProxy<JoystickData, tims::class_id::kJoystick> {
 public:
  JoystickProxy(tims::Mailbox& work, tims::Address component,
                const ProxyTimeouts& timeouts = {.data = std::chrono::seconds(1)})
      : DataProxy(work, component, timeouts) {}
};

}  // namespace rack

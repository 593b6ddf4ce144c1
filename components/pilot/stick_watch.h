// How long a pilot goes on with the last position of its stick.
//
// A stick on the robot's own host that is silent for ten periods is broken: the pilot ends with an
// error, as in the original. A stick in a browser or on another host is silent whenever the network
// is: after a much shorter time the vehicle must stand, and it drives on when the stick is heard
// again. Pure.
#pragma once

#include "tims/time.h"

namespace rack::pilot {

class StickWatch {
 public:
  // `look_period`: of the calls of must_stand().
  StickWatch(tims::Duration remote_timeout, tims::Duration look_period)
      : remote_timeout_(remote_timeout), look_period_(look_period) {}

  // A position came. `is_remote`: from a browser, a TCP client or another host.
  void heard(tims::Time now, bool is_remote) {
    heard_ = now;
    is_remote_ = is_remote;
  }

  // True: at the next look it would be silent for longer than the time for remote sticks. Never of
  // a stick on this host, nor before the first position.
  [[nodiscard]] bool must_stand(tims::Time now) const {
    return is_remote_ && now - heard_ + look_period_ > remote_timeout_;
  }

 private:
  tims::Duration remote_timeout_;
  tims::Duration look_period_;
  tims::Time heard_{};
  bool is_remote_ = false;
};

}  // namespace rack::pilot

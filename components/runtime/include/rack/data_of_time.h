// Data of a partner at a given time, such as the pose where a scan was taken. The partner may not
// have data of that time yet: then this waits for its next data, instead of asking for what it has
// to refuse.
//
//   DataOfTime<OdometryProxy> pose_;
//
//   auto good = pose_.get(*odometry_, data, scan.recordingTime, std::chrono::milliseconds(300));
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>

#include "rack/clock.h"
#include "rack/codec/quantity.h"
#include "tims/result.h"
#include "tims/time.h"

namespace rack {

// For one partner and one thread.
template <typename ProxyType>
class DataOfTime {
 public:
  using Data = typename ProxyType::Data;

  // kTimeout: it has no data of that time until `patience` is over. Other errors are those of the
  // proxy; kAnsweredError: also data that it no longer has.
  tims::Result<void> get(ProxyType& proxy, Data& data, TimeStamp time, tims::Duration patience) {
    const tims::Time end = now() + patience;
    bool asked = false;
    while (!newest_ || time - *newest_ > std::chrono::milliseconds(0)) {
      const tims::Duration left = end - now();
      if (asked && left <= tims::Duration::zero())
        return tims::Error(tims::Errc::kTimeout,
                           "there are no data of time " + std::to_string(time.raw()) + " ms yet");
      auto come = asked ? proxy.get_next_data(data, left) : proxy.get_data(data);
      if (!come) return come;
      newest_ = data.recordingTime;
      asked = true;
    }
    return proxy.get_data(data, time);
  }

 private:
  std::optional<TimeStamp> newest_;  // the newest data that the partner is known to have
};

}  // namespace rack

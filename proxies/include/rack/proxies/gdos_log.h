// The log of a robot: it owns the sink of texts, keeps them, and passes them on to whoever
// subscribes, here or at the other end of the fleet.
#pragma once

#include <string_view>

#include "rack/proxies/gdos.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct GdosLogType {
  enum : i8 {
    kGetLog = 21,  // to the sink: who keeps the texts; answered by kLog
    kLog = -21,    // GdosLogAddress
  };
};

struct GdosLogAddress {
  tims::Address log = {};  // of the component whose data are texts
  u32 version = 1;         // of those data
};

// One text. A listener gets each; now and then one of level 0, which says that nothing was said.
struct GdosData {
  TimeStamp recordingTime = 0;
  tims::Address sender = {};
  i32 level = 0;  // a gdos::Level
  Count textNum = {};
  Sequence<char, gdos::kTextMax> text = {};  // UTF-8

  [[nodiscard]] std::string_view words() const { return {text.data(), text.size()}; }
};

using GdosLogProxy = DataProxy<GdosData>;

}  // namespace rack

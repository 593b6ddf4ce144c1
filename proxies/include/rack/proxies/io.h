// Digital and analogue inputs and outputs as bytes, whose meaning depends on the component
// (specification, section 9.7).
#pragma once

#include "rack/proxies/proxy.h"

namespace rack {

struct IoType {
  enum : i8 {
    kSetData = 21,  // IoData
  };
};

struct IoData {
  TimeStamp recordingTime = 0;
  Count valueNum = {};
  // Original programs accept up to 128 values, those built for the Velodyne laser 800000.
  Sequence<u8, 800000> values = {};
};

class IoProxy : public DataProxy<IoData, tims::class_id::kIo> {
 public:
  using DataProxy::DataProxy;

  Result<void> set_data(const IoData& data) { return command(IoType::kSetData, data); }
};

}  // namespace rack

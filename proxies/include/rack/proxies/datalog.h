// The recorder, and the list of messages to record (specification, section 9.23).
#pragma once

#include "rack/proxies/proxy.h"

namespace rack {

struct DatalogType {
  enum : i8 {
    kInitLog = 21,       // builds a new list when the recorder is off
    kSetLog = 22,        // DatalogData; ERROR when logNum differs from that of the list
    kGetLogStatus = 23,  // answered by kLogStatus
    kLogStatus = -23,    // DatalogData
  };
};

struct DatalogLogInfo {
  i32 logEnable = 0;                         // 1: record it
  tims::Address moduleMbx = {};              // of the producer
  Milliseconds<u32> periodTime = 0;          // 0: everything
  Quantity<i32, unit::Byte> maxDataLen = 0;  // of the largest expected body
  Text<40> filename = {};
  Quantity<u32, unit::Byte> bytesLogged = 0;
  u32 setsLogged = 0;
};

struct DatalogData {
  TimeStamp recordingTime = 0;
  Text<40> logPathName = {};  // directory of the files, with its trailing slash
  Count logNum = {};
  Sequence<DatalogLogInfo, 100> logInfo = {};

  // The original answers kGetLogStatus with all 100 entries, however many are used.
  static constexpr std::size_t kWholeSize = 48 + 100 * 64;
};

class DatalogProxy : public DataProxy<DatalogData, tims::class_id::kDatalog> {
 public:
  using DataProxy::DataProxy;

  Result<void> init_log() { return command(DatalogType::kInitLog); }
  Result<void> set_log(const DatalogData& log) { return command(DatalogType::kSetLog, log); }
  // The original program first queries every module on its list, and waits 1 s for each that does
  // not answer.
  Result<DatalogData> get_log_status(tims::Duration timeout = std::chrono::seconds(5)) {
    return query<DatalogData>(DatalogType::kGetLogStatus, DatalogType::kLogStatus, timeout);
  }
};

}  // namespace rack

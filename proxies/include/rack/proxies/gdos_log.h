// The log of a robot: it owns the text sink, stores the texts, and forwards them to its subscribers
// on this host or anywhere in the fleet.
#pragma once

#include <string_view>

#include "rack/proxies/gdos.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct GdosLogType {
  enum : i8 {
    kGetLog = 21,    // sent to the sink: requests the address of the log; answered by kLog
    kLog = -21,      // GdosLogAddress
    kGetTexts = 22,  // sent to the log: requests the newest texts that it has stored
    kTexts = -22,    // GdosTexts
  };
};

struct GdosLogAddress {
  tims::Address log = {};  // the component that publishes the texts as data
  u32 version = 1;         // format version of those data
};

// One text. A listener receives each of them, and from time to time one with level 0, which only
// shows that the log is running.
struct GdosData {
  TimeStamp recordingTime = 0;
  tims::Address sender = {};
  i32 level = 0;  // a gdos::Level
  Count textNum = {};
  Sequence<char, gdos::kTextMax> text = {};  // UTF-8

  [[nodiscard]] std::string_view as_text() const { return {text.data(), text.size()}; }
};

inline constexpr std::size_t kGdosTextsMax = 60000;  // bytes

// The newest lines of the files, oldest first: JSON, a text a line (`timsctl log show --json`).
struct GdosTexts {
  Count textNum = {};  // bytes
  Sequence<char, kGdosTextsMax> text = {};

  [[nodiscard]] std::string_view as_text() const { return {text.data(), text.size()}; }
};

class GdosLogProxy : public DataProxy<GdosData> {
 public:
  using DataProxy::DataProxy;

  Result<GdosTexts> get_texts() {
    return query<GdosTexts>(GdosLogType::kGetTexts, GdosLogType::kTexts);
  }
};

}  // namespace rack

// What a thermometer says and is told: its messages, in one place. Everything else about them is
// made of this file: bytes in either order, the calls of the proxy, and the description by which
// timsctl and DatalogRec know their fields (rack_message_file() in CMakeLists.txt).
#pragma once

#include <rack/proxies/catalogue.h>
#include <rack/proxies/proxy.h>

namespace thermometer {

// Of the class in addresses. RACK's own are below 128.
inline constexpr rack::u32 kThermometer = 128;

// Units of one's own have a name, the name of their SI unit, and what one of them is in it.
struct Millikelvin {
  static constexpr std::string_view kName = "mK";
  static constexpr std::string_view kSiName = "K";
  static constexpr double kSi = 1e-3;
};
using Temperature = rack::Quantity<rack::i32, Millikelvin>;

struct ThermometerType {
  enum : rack::i8 {
    kSetLimit = rack::kFirstCommand,  // ThermometerLimit
  };
};

// A struct's fields are its layout. Lengths that vary: a Count, and behind all other fields the
// Sequence. The data of a component begin with the time.
struct ThermometerData {
  rack::TimeStamp recordingTime = 0;
  Temperature temperature = 0;  // smoothed
  Temperature limit = 0;
  rack::u8 tooHot = 0;  // 1: above the limit
  rack::Count sampleNum = {};
  rack::Sequence<Temperature, 16> samples = {};  // what it is made of, newest last
};

struct ThermometerLimit {
  Temperature limit = 353150;
};

inline constexpr rack::MessageInfo kMessages[] = {
    {kThermometer, tims::type::kData, "DATA", rack::kBody<ThermometerData>},
    {kThermometer, ThermometerType::kSetLimit, "SET_LIMIT", rack::kBody<ThermometerLimit>},
};
inline constexpr rack::ClassInfo kThermometerClass = {kThermometer, "Thermometer", kMessages};

// What other components call.
class ThermometerProxy : public rack::DataProxy<ThermometerData> {
 public:
  using DataProxy::DataProxy;

  rack::Result<void> set_limit(Temperature limit) {
    return command(ThermometerType::kSetLimit, ThermometerLimit{limit});
  }
};

}  // namespace thermometer

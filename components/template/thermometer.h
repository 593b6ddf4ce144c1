// The messages of a thermometer, in one place. Everything else is derived from this file: the
// encoding in both byte orders, the calls of the proxy, and the description that gives timsctl and
// DatalogRec the fields (rack_message_file() in CMakeLists.txt).
#pragma once

#include <rack/proxies/catalogue.h>
#include <rack/proxies/proxy.h>

namespace thermometer {

// The class id in addresses. Ids below 128 are reserved for RACK.
inline constexpr rack::u32 kThermometer = 128;

// A custom unit has a name, the name of its SI unit, and its size in that unit.
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

// The fields of a struct are its layout. For a variable length: a Count, and a Sequence after all
// other fields. The data of a component begin with the time.
struct ThermometerData {
  rack::TimeStamp recordingTime = 0;
  Temperature temperature = 0;  // smoothed
  Temperature limit = 0;
  rack::u8 tooHot = 0;  // 1: above the limit
  rack::Count sampleNum = {};
  rack::Sequence<Temperature, 16> samples = {};  // the averaged samples, newest last
};

struct ThermometerLimit {
  Temperature limit = 353150;
};

inline constexpr rack::MessageInfo kMessages[] = {
    {kThermometer, tims::type::kData, "DATA", rack::kBody<ThermometerData>},
    {kThermometer, ThermometerType::kSetLimit, "SET_LIMIT", rack::kBody<ThermometerLimit>},
};
inline constexpr rack::ClassInfo kThermometerClass = {kThermometer, "Thermometer", kMessages};

// The interface for other components.
class ThermometerProxy : public rack::DataProxy<ThermometerData, kThermometer> {
 public:
  using DataProxy::DataProxy;

  rack::Result<void> set_limit(Temperature limit) {
    return command(ThermometerType::kSetLimit, ThermometerLimit{limit});
  }
};

}  // namespace thermometer

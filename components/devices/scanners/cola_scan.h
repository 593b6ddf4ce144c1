// LMDscandata: a scan of SICK's scanners in CoLa, with all that may come with it. What a scanner
// sends of it is set by LMDscandatacfg.
//
// Angles count counter-clockwise from the scanner's right, so that 90 degrees is its front. Values
// below 16 are codes: nothing came back, dazzled, not plausible.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "components/devices/scanners/cola.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

struct ColaEncoder {
  std::uint32_t position = 0;
  std::uint16_t speed = 0;
};

struct ColaChannel {
  std::array<char, 5> content{};  // DIST1 to DIST5 and RSSI1 to RSSI5, by echo
  float scale = 1;
  float offset = 0;
  std::int32_t start_angle = 0;  // 1/10000 degree
  std::uint16_t step = 0;        // 1/10000 degree
  bool is_wide = true;           // 16 bits a value, else 8
  std::vector<std::uint16_t> values{};

  [[nodiscard]] std::string_view name() const { return {content.data(), content.size()}; }
};

struct ColaPosition {
  std::array<float, 3> place{};
  std::array<float, 3> rotation{};
  std::uint8_t rotation_type = 0;
  std::uint8_t transmits_name = 0;
};

struct ColaTime {
  std::uint16_t year = 0;
  std::uint8_t month = 0, day = 0, hour = 0, minute = 0, second = 0;
  std::uint32_t microsecond = 0;
};

struct ColaEvent {
  std::array<char, 4> type{};
  std::uint32_t encoder = 0;
  std::uint32_t time = 0;
  std::int32_t angle = 0;
};

struct ColaScan {
  std::uint16_t version = 0;
  std::uint16_t device_number = 0;
  std::uint32_t serial_number = 0;
  std::array<std::uint8_t, 2> device_status{};
  std::uint16_t telegram_counter = 0;
  std::uint16_t scan_counter = 0;
  std::uint32_t started = 0;      // microseconds since the scanner was switched on
  std::uint32_t transmitted = 0;  // microseconds
  std::array<std::uint8_t, 2> inputs{};
  std::array<std::uint8_t, 2> outputs{};
  std::int16_t layer_angle = 0;           // of a scanner with several layers
  std::uint32_t scan_frequency = 0;       // 1/100 Hz
  std::uint32_t measuring_frequency = 0;  // 100 Hz
  std::vector<ColaEncoder> encoders{};
  // Those with 16 bits first; room that is not used is kept.
  std::vector<ColaChannel> channels{};
  std::size_t channel_count = 0;
  std::optional<ColaPosition> position{};
  std::string name{};
  std::string comment{};
  std::optional<ColaTime> time{};
  std::optional<ColaEvent> event{};

  [[nodiscard]] const ColaChannel* channel(std::string_view content) const;
  // One whole turn of the mirror.
  [[nodiscard]] Duration turn() const;
  // Flags of both bytes: 1 error, 2 the front screen becomes dirty, 4 too dirty to measure.
  [[nodiscard]] unsigned status() const { return device_status[0] | device_status[1]; }
};

// An event or an answer with a scan. False: it is none, or broken. Does not allocate where `scan`
// has held as much before.
bool decode_cola_scan(const ColaTelegram& telegram, ColaScan& scan);
// Appends the body of an event ("sSN LMDscandata") or an answer ("sRA LMDscandata").
void append_cola_scan(std::vector<std::byte>& body, ColaDialect dialect, const ColaScan& scan,
                      std::string_view command = "sSN LMDscandata");

struct ColaView {
  std::int32_t max_range = 20000;        // mm; telegrams do not tell
  std::int32_t reflector_remission = 0;  // from there on it is a reflector; 0: none is
};

// The first echo, clockwise. A scan with more values than LadarData has is thinned evenly. False:
// there are no distances.
bool scan_of_cola(const ColaScan& from, const ColaView& view, LadarData& scan);

}  // namespace rack::device

// LMDscandata: a scan of SICK scanners in CoLa, with all optional parts. LMDscandatacfg determines
// which parts a scanner sends.
//
// Angles are mostly counterclockwise from the right of the scanner, so that 90 degrees is its front
// (cola_front.h). Values below 16 are codes: no echo, dazzled, not plausible.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "components/devices/scanners/cola.h"
#include "components/devices/scanners/cola_front.h"
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
  bool is_wide = true;           // 16 bits per value, else 8
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
  std::uint32_t started = 0;      // microseconds since power-on of the scanner
  std::uint32_t transmitted = 0;  // microseconds
  std::array<std::uint8_t, 2> inputs{};
  std::array<std::uint8_t, 2> outputs{};
  std::int16_t layer_angle = 0;           // for scanners with several layers
  std::uint32_t scan_frequency = 0;       // 1/100 Hz
  std::uint32_t measuring_frequency = 0;  // 100 Hz
  std::vector<ColaEncoder> encoders{};
  // Channels with 16 bits come first; unused capacity is kept.
  std::vector<ColaChannel> channels{};
  std::size_t channel_count = 0;
  std::optional<ColaPosition> position{};
  std::string name{};
  std::string comment{};
  std::optional<ColaTime> time{};
  std::optional<ColaEvent> event{};

  [[nodiscard]] const ColaChannel* channel(std::string_view content) const;
  // Duration of one turn of the mirror.
  [[nodiscard]] Duration turn() const;
  // Flags of both bytes: 1 error, 2 front screen getting dirty, 4 too dirty to measure.
  [[nodiscard]] unsigned status() const { return device_status[0] | device_status[1]; }
};

// Decodes an event or an answer with a scan. Returns false for other or invalid telegrams. Does not
// allocate if the capacity of `scan` suffices.
bool decode_cola_scan(const ColaTelegram& telegram, ColaScan& scan);
// Appends the body of an event ("sSN LMDscandata") or an answer ("sRA LMDscandata").
void append_cola_scan(std::vector<std::byte>& body, ColaDialect dialect, const ColaScan& scan,
                      std::string_view command = "sSN LMDscandata");

struct ColaView {
  std::int32_t max_range = 20000;        // mm; not part of the telegrams
  std::int32_t reflector_remission = 0;  // minimum remission of a reflector; 0: no reflectors
  ColaFront front{};
};

// Converts the first echo to a clockwise scan. A scan with more values than LadarData can hold is
// thinned evenly. Returns false if there are no distances.
bool scan_of_cola(const ColaScan& from, const ColaView& view, LadarData& scan);

}  // namespace rack::device

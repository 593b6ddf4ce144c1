// Ouster scanners (OS-0, OS-1, OS-2, OS-Dome): datagrams to UDP port 7502.
//
// The metadata of the scanner (JSON: http://SCANNER/api/v1/sensor/metadata) contain the layout of a
// datagram and the direction of each beam. A datagram is a header (32 bytes, none in the old
// layout), columns, and a footer. A column has its time (u64, ns), its index in the turn (u16), its
// state, and a pixel per beam, from top to bottom; columns are clockwise.
//
// Source: Ouster's firmware user manual; layouts from the manufacturer's library.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "components/devices/scan3d/spinning_scan.h"
#include "rack/devices/device_clock.h"

namespace rack::device {

struct OusterLayout {
  std::size_t head_bytes = 32;
  std::size_t column_head_bytes = 12;
  std::size_t pixel_bytes = 16;
  std::size_t column_foot_bytes = 0;
  std::size_t foot_bytes = 32;
  std::uint32_t range_mask = 0x7FFFF;
  i32 range_unit = 1;  // mm
  std::size_t reflectivity_at = 3;
  bool is_legacy = false;  // each column contains the frame number

  std::size_t columns_of_packet = 16;
  std::size_t columns_of_turn = 1024;
  std::size_t first_column = 0;  // first of the columns that are sent
  std::size_t last_column = 1023;
  std::size_t beams = 0;

  [[nodiscard]] std::size_t column_bytes() const {
    return column_head_bytes + beams * pixel_bytes + column_foot_bytes;
  }
  [[nodiscard]] std::size_t packet_bytes() const {
    return head_bytes + columns_of_packet * column_bytes() + foot_bytes;
  }
};

struct OusterMetadata {
  OusterLayout layout{};
  std::vector<double> altitudes;  // elevation of each beam, deg, upwards
  std::vector<double> azimuths;   // offset of each beam from the direction of the head, deg
  double beam_origin = 0;         // distance of the beam origin from the axis, mm
  double height = 0;              // height of the lasers above the scanner's base, mm
  std::string product;

  // The text of kMalformed names the missing or invalid item.
  static tims::Result<OusterMetadata> parse(std::string_view json);
};

struct OusterPixel {
  i32 range = 0;  // mm; 0: no echo
  std::uint8_t reflectivity = 0;
};

struct OusterColumn {
  std::uint64_t time = 0;  // ns, clock of the scanner
  std::uint16_t number = 0;
  std::uint16_t frame = 0;  // number of the turn
  bool is_valid = false;
  std::span<const std::byte> pixels{};
};

// Decodes a column; the datagram must have the right size.
OusterColumn ouster_column(const OusterLayout& layout, std::span<const std::byte> packet,
                           std::size_t column);
OusterPixel ouster_pixel(const OusterLayout& layout, const OusterColumn& column, std::size_t beam);

class Ouster final : public Dialogue {
 public:
  Ouster(OusterMetadata metadata, const SpinSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

  [[nodiscard]] bool is_ready() const { return has_received_; }
  bool take(Scan3dData& scan, Time& recorded) { return scan_.take(scan, recorded); }

  // Number of invalid datagrams, and of those with another layout.
  [[nodiscard]] std::uint64_t broken() const { return broken_; }
  [[nodiscard]] std::uint64_t lost() const { return scan_.lost(); }

 private:
  struct Beam {
    float level = 0;  // horizontal part of a distance
    float down = 0;
    float cos = 1;  // cosine of the azimuth offset
    float sin = 0;
  };

  void take_column(const OusterColumn& column, Time when);
  [[nodiscard]] int sector_of(std::size_t column) const;

  OusterMetadata metadata_;
  SpinningScan scan_;
  std::vector<Beam> beams_;
  std::vector<std::array<float, 2>> directions_;  // cos, sin of each column
  DeviceClock clock_;
  std::uint16_t frame_ = 0;
  bool has_received_ = false;
  std::uint64_t broken_ = 0;
};

}  // namespace rack::device

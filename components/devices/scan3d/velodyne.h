// Velodyne scanners (VLP-16, Puck LITE and Hi-Res, HDL-32E, VLP-32C): datagrams to UDP port 2368.
//
// A datagram has 12 blocks of 100 bytes: FF EE, azimuth in 1/100 degree (clockwise from the front),
// 32 times distance (u16) and reflectivity (u8); at its end microseconds since the full hour (u32),
// return mode (37 strongest, 38 last, 39 both: blocks in pairs), and the model. All little-endian.
// A block of the VLP-16 contains its 16 lasers twice.
//
// Source: Velodyne's manuals (63-9243 VLP-16, 63-9113 HDL-32E, 63-9325 VLP-32C).
#pragma once

#include <array>
#include <vector>

#include "components/devices/scan3d/spinning_scan.h"
#include "rack/devices/device_clock.h"

namespace rack::device {

enum class VelodyneModel : std::uint8_t {
  kHdl32 = 0x21,
  kVlp16 = 0x22,
  kPuckHiRes = 0x24,
  kVlp32 = 0x28,
};

struct VelodyneLaser {
  double elevation = 0;  // deg, upwards
  double azimuth = 0;    // offset from the direction of the head, deg
  double above = 0;      // height of the beam origin, mm
};

struct VelodyneLayout {
  std::span<const VelodyneLaser> lasers{};
  double firing_us = 0;    // time from one laser (or pair) to the next, us
  double sequence_us = 0;  // duration of a sequence of all lasers, us
  int at_once = 1;         // number of lasers fired simultaneously
  i32 range_unit = 2;      // mm
  i32 range_max = 0;       // mm
};

// The layout of a model, which is the last byte of a datagram. Null for unknown models.
const VelodyneLayout* velodyne_layout(std::uint8_t model);

namespace velodyne {
inline constexpr std::size_t kBlocks = 12;
inline constexpr std::size_t kBlockBytes = 100;
inline constexpr std::size_t kReturns = 32;  // per block
inline constexpr std::size_t kTailBytes = 6;
inline constexpr std::size_t kBytes = kBlocks * kBlockBytes + kTailBytes;  // minimum size
inline constexpr std::uint32_t kTurn = 36000;                              // 1/100 degree
inline constexpr std::uint8_t kDualReturn = 0x39;
}  // namespace velodyne

class Velodyne final : public Dialogue {
 public:
  explicit Velodyne(const SpinSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

  [[nodiscard]] bool is_ready() const { return has_received_; }
  bool take(Scan3dData& scan, Time& recorded) { return scan_.take(scan, recorded); }

  [[nodiscard]] std::uint64_t broken() const { return broken_; }
  [[nodiscard]] std::uint64_t lost() const { return scan_.lost(); }

 private:
  struct Beam {
    float level = 0;  // horizontal part of a distance
    float down = 0;
    float begin = 0;            // beam origin, mm downwards
    std::uint32_t azimuth = 0;  // 1/100 degree
    std::size_t rank = 0;       // index from the bottom
  };

  void set_model(std::uint8_t model);
  void take_block(std::span<const std::byte> block, std::uint32_t azimuth, std::uint32_t turned,
                  Time began);

  SpinningScan scan_;
  const VelodyneLayout* layout_ = nullptr;
  std::uint8_t model_ = 0;
  std::vector<Beam> beams_;
  std::vector<std::array<float, 2>> directions_;  // cos, sin for each 1/100 degree
  DeviceClock clock_;
  std::uint32_t last_head_ = 0;  // 1/100 degree
  bool has_received_ = false;
  std::uint64_t broken_ = 0;
};

}  // namespace rack::device

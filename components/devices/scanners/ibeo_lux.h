// Ibeo Lux over TCP, port 12002. The scanner sends without requests.
//
// A message is AF FE C0 C2, the size of the previous message, its own size, a byte, the device id,
// the type, and its time, all big-endian; then the body, little-endian. Times have the NTP format,
// 64 bits: seconds since 1900 and their fraction.
//
//   2202  a scan: points of four layers and up to three echoes, in cm
//   2221  recognised objects with boxes, speeds, classes and contours
//
// x is ahead, y to the left, angles are counterclockwise.
//
// Source: RACK 0.6.1; PolySync's ibeo_lux_4l_driver.h and AutonomouStuff's ibeo_core, which agree
// (Ibeo's document FF5.7.4). RACK read the fraction of the time of objects as seconds.
#pragma once

#include <vector>

#include "rack/devices/device_clock.h"
#include "rack/devices/stream_buffer.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/obj_recog.h"

namespace rack::device {

namespace lux {
inline constexpr std::uint16_t kScan = 0x2202;
inline constexpr std::uint16_t kObjects = 0x2221;
inline constexpr std::size_t kHead = 24;
inline constexpr std::size_t kScanHead = 44;
inline constexpr std::size_t kPoint = 10;
inline constexpr std::size_t kObjectsHead = 10;
inline constexpr std::size_t kObject = 58;
}  // namespace lux

// Converts an NTP time to microseconds.
constexpr std::int64_t lux_microseconds(std::uint64_t ntp) {
  return static_cast<std::int64_t>((ntp >> 32) * 1'000'000 +
                                   ((ntp & 0xFFFF'FFFF) * 1'000'000 >> 32));
}

struct LuxMessage {
  std::uint16_t kind = 0;
  std::int64_t made = 0;  // microseconds
  std::span<const std::byte> body{};
  Time began{};
};

// Valid until the next call.
class LuxMessages {
 public:
  void add(const Arrival& arrival) { buffer_.add(arrival); }
  bool next(LuxMessage& message);
  void clear();

  // Number of bytes that belong to no message.
  [[nodiscard]] std::uint64_t lost() const { return lost_; }

 private:
  static constexpr std::size_t kBodyMax = 102'400;

  StreamBuffer buffer_{2 * kBodyMax};
  std::size_t used_ = 0;
  std::uint64_t lost_ = 0;
};

struct LuxScan {
  std::int64_t begin = 0;  // microseconds
  std::int64_t end = 0;
};
// Decodes the points layer by layer, up to the capacity of the scan. `only_nearest`: keeps only the
// nearest object at each angle of a layer. Returns false if the body is truncated or invalid.
bool decode_lux_scan(std::span<const std::byte> body, bool only_nearest, LadarData& scan,
                     LuxScan& times);

// Decodes boxes, and contours as one object per line segment. `absolute`: speeds over ground
// instead of relative ones. Returns false if the body is truncated.
bool decode_lux_objects(std::span<const std::byte> body, bool absolute, ObjRecogData& boxes,
                        ObjRecogData& contours, std::int64_t& began);

struct IbeoLuxSettings {
  bool only_nearest = false;
  bool absolute_speeds = false;
};

class IbeoLux final : public Dialogue {
 public:
  explicit IbeoLux(const IbeoLuxSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;

  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(LadarData& scan, Time& recorded);
  bool take_objects(ObjRecogData& boxes, ObjRecogData& contours, Time& recorded);
  [[nodiscard]] std::uint64_t lost() const { return messages_.lost(); }

 private:
  void take_scan(const LuxMessage& message);
  void take_list(const LuxMessage& message);
  [[nodiscard]] Time host_time(const LuxMessage& message, std::int64_t when);

  IbeoLuxSettings settings_;
  LuxMessages messages_;
  DeviceClock clock_{std::chrono::microseconds(1), 1ULL << 62};
  bool is_ready_ = false;
  LadarData scan_{};
  bool has_scan_ = false;
  Time recorded_{};
  ObjRecogData boxes_{};
  ObjRecogData contours_{};
  bool has_objects_ = false;
  Time objects_recorded_{};
};

}  // namespace rack::device

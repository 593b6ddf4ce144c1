// Emulator of an Ibeo Lux: scans of a room in four layers, and a car that drives through it.
#pragma once

#include <vector>

#include "components/devices/scanners/ibeo_lux.h"
#include "components/devices/scanners/room.h"

namespace rack::device::emulator {

struct IbeoLuxSettings {
  Duration period = std::chrono::milliseconds(80);
  std::uint64_t ntp = 0xE8D5'0000'0000'0000;  // time at power-on
  bool has_contour_fault = false;             // FFFF points
  Sight sight = Room{};
};

class IbeoLux final : public Dialogue {
 public:
  explicit IbeoLux(const IbeoLuxSettings& settings = {}) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival&, Output&) override {}
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

 private:
  void append_head(std::uint16_t kind, std::size_t size, Time now);
  void append_scan(Time begin, Time end, Time now);
  void append_objects(Time begin, Time now);
  void append(std::int64_t number, int bytes);
  [[nodiscard]] std::uint64_t ntp(Time time) const;

  IbeoLuxSettings settings_;
  Time began_{};
  Time next_ = tims::kNever;
  std::uint32_t before_ = 0;  // size of the previous message
  std::uint16_t number_ = 0;
  std::vector<std::byte> body_;
  std::vector<std::byte> message_;
};

}  // namespace rack::device::emulator

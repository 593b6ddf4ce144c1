// SICK S300 and S3000, safety laser scanners, over a serial line (RS-422, 500 kbaud).
//
// Set up for continuous output they send every scan by themselves and are not spoken to:
//
//    0  00 00 00 00  00 00   size (u16, big-endian, words from byte 4 to the end; versions from
//       3.01 on leave two out)
//    8  FF, 07 the EFI bus master or 08 its slave, version (2), status (2), scan number (4),
//       telegram number (2)
//   20  BB BB distances, 11 11 of the first field, then values (u16, little-endian)
//       CRC (u16, little-endian) of all bytes from 4 on: CCITT, begins with FFFF
//
// A value has centimetres in 13 bits and flags: 13 reflector, 14 protective field, 15 warning
// field. Other blocks, AA AA of inputs and outputs and CC CC of reflectors, are no scans.
//
// Sources: SICK's "Telegram listing S3000/S300"; what RACK 0.6.1 reads; drivers for ROS.
#pragma once

#include <array>
#include <optional>

#include "components/devices/core/stream_buffer.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

std::uint16_t sick_s_crc(std::span<const std::byte> bytes);

struct SickSTelegram {
  std::uint8_t address = 0;  // 7 master, 8 slave
  std::uint32_t scan_number = 0;
  std::span<const std::byte> blocks{};  // from BB BB to before the CRC; valid until the next call
  Time began{};                         // its first byte on the line
};

void append_sick_s(std::vector<std::byte>& out, const SickSTelegram& telegram);

class SickSTelegrams {
 public:
  void add(const Arrival& arrival) { buffer_.add(arrival); }
  bool next(SickSTelegram& telegram);
  void clear() {
    buffer_.clear();
    used_ = 0;
  }

  // Telegrams with a wrong CRC.
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  // The longest: 761 values of an S3000 a quarter degree apart, with some blocks besides.
  static constexpr std::size_t kTelegramMax = 4096;

  StreamBuffer buffer_{2 * kTelegramMax};
  std::uint64_t broken_ = 0;
  std::size_t used_ = 0;  // of the telegram that was handed out
};

enum class SickSDevice : std::uint8_t { kS300, kS3000 };

struct SickSSettings {
  SickSDevice device = SickSDevice::kS300;
  bool is_slave = false;  // of the EFI bus
  std::uint32_t baud = 500000;
};

// 270 or 190 degrees, half a degree apart, clockwise. False: it is no scan of this device.
bool decode_sick_s_scan(const SickSTelegram& telegram, SickSDevice device, LadarData& scan);

// Listens only: to a recording it is the same.
class SickS final : public Dialogue {
 public:
  explicit SickS(const SickSSettings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return timeout_; }

  // From the first scan on.
  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(LadarData& scan, Time& recorded);
  [[nodiscard]] std::uint64_t broken() const { return telegrams_.broken(); }

 private:
  [[nodiscard]] std::string complaint() const;

  SickSSettings settings_;
  SickSTelegrams telegrams_;
  bool is_ready_ = false;
  Time timeout_ = tims::kNever;
  // What came instead of a scan.
  std::uint64_t bytes_ = 0;
  std::uint64_t of_others_ = 0;  // from the other address
  std::uint64_t unknown_ = 0;    // no such scan
  LadarData scan_{};
  bool has_scan_ = false;
  Time recorded_{};
};

}  // namespace rack::device

// SICK S300 and S3000, safety laser scanners, over a serial line (RS-422, 500 kbaud).
//
// Configured for continuous output, they send every scan without requests:
//
//    0  00 00 00 00  00 00   size (u16, big-endian, in units of 2 bytes from byte 4 to the end;
//       versions from 3.01 on exclude two units)
//    8  FF, 07 for the EFI bus master or 08 for its slave, version (2), status (2), scan number
//    (4),
//       telegram number (2)
//   20  BB BB distances, 11 11 of the first field, then values (u16, little-endian)
//       CRC (u16, little-endian) of all bytes from 4 on: CCITT, initial value FFFF
//
// A value has the distance in cm in 13 bits and flags: bit 13 reflector, 14 protective field, 15
// warning field. Other blocks, AA AA for inputs and outputs and CC CC for reflectors, are not
// scans.
//
// Sources: SICK's "Telegram listing S3000/S300"; RACK 0.6.1; ROS drivers.
#pragma once

#include <array>
#include <optional>

#include "rack/devices/stream_buffer.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

std::uint16_t sick_s_crc(std::span<const std::byte> bytes);

struct SickSTelegram {
  std::uint8_t address = 0;  // 7 master, 8 slave
  std::uint32_t scan_number = 0;
  std::span<const std::byte> blocks{};  // from BB BB to before the CRC; valid until the next call
  Time began{};                         // when its first byte was on the line
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

  // Number of telegrams with a wrong CRC.
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  // Longest telegram: 761 values of an S3000 with a step of 0.25 degrees, with some other blocks.
  static constexpr std::size_t kTelegramMax = 4096;

  StreamBuffer buffer_{2 * kTelegramMax};
  std::uint64_t broken_ = 0;
  std::size_t used_ = 0;  // size of the telegram that was returned
};

enum class SickSDevice : std::uint8_t { kS300, kS3000 };

struct SickSSettings {
  SickSDevice device = SickSDevice::kS300;
  bool is_slave = false;  // slave of the EFI bus
  std::uint32_t baud = 500000;
};

// Decodes a clockwise scan of 270 or 190 degrees with a step of 0.5 degrees. Returns false if it is
// not a scan of this device.
bool decode_sick_s_scan(const SickSTelegram& telegram, SickSDevice device, LadarData& scan);

// Only listens, so recordings need no special treatment.
class SickS final : public Dialogue {
 public:
  explicit SickS(const SickSSettings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

  // True after the first scan.
  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(LadarData& scan, Time& recorded);
  [[nodiscard]] std::uint64_t broken() const { return telegrams_.broken(); }

 private:
  [[nodiscard]] std::string complaint() const;

  SickSSettings settings_;
  SickSTelegrams telegrams_;
  bool is_ready_ = false;
  // Data received instead of a scan, for the error message.
  std::uint64_t bytes_ = 0;
  std::uint64_t of_others_ = 0;  // telegrams from the other address
  std::uint64_t unknown_ = 0;    // telegrams without a scan of this device
  LadarData scan_{};
  bool has_scan_ = false;
  Time recorded_{};
};

}  // namespace rack::device

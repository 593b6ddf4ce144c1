#include "components/devices/positioning/binary_protocols.h"

#include <algorithm>

namespace rack::device {
namespace {

// The bytes at the beginning of each packet, and at its end if the protocol has such.
struct BinaryProtocol {
  std::string_view text;
  std::uint32_t begin = 0;
  std::uint32_t begin_mask = 0;
  std::uint32_t end = 0;
  std::uint32_t end_mask = 0;
};

constexpr std::uint32_t kTwo = 0xFFFF;
constexpr std::uint32_t kThree = 0xFFFFFF;

constexpr std::array<BinaryProtocol, 5> kBinaryProtocols = {{
    {.text = "UBX, the binary protocol of u-blox; use GpsUblox, which reads it",
     .begin = 0xB562,
     .begin_mask = kTwo},
    {.text = "SiRF binary, which no program of RACK reads; switch it to NMEA (gpsctl -n of gpsd)",
     .begin = 0xA0A2,
     .begin_mask = kTwo,
     .end = 0xB0B3,
     .end_mask = kTwo},
    {.text = "TSIP, the binary protocol of Trimble, which no program of RACK reads; switch it to "
             "NMEA (gpsctl -n of gpsd)",
     .begin = 0x1003,  // the end of a packet; a single 10 begins one
     .begin_mask = kTwo,
     .end = 0x100310,
     .end_mask = kThree},
    {.text = "messages of NovAtel OEM, which no program of RACK reads; configure NMEA (LOG GPRMC "
             "ONTIME 1)",
     .begin = 0xAA4412,
     .begin_mask = kThree},
    {.text = "SBF, the binary protocol of Septentrio, which no program of RACK reads; configure "
             "NMEA (setNMEAOutput)",
     .begin = 0x2440,
     .begin_mask = kTwo},
}};

// At a wrong baud rate, any two bytes may come once.
constexpr std::uint32_t kOften = 2;

}  // namespace

void BinaryProtocols::add(std::span<const std::byte> bytes) {
  for (const std::byte byte : bytes) {
    last_ = last_ << 8 | std::to_integer<std::uint32_t>(byte);
    for (std::size_t i = 0; i < kProtocols; ++i) {
      const BinaryProtocol& protocol = kBinaryProtocols[i];
      if ((last_ & protocol.begin_mask) == protocol.begin) ++begun_[i];
      if (protocol.end_mask != 0 && (last_ & protocol.end_mask) == protocol.end) ++ended_[i];
    }
  }
}

std::string_view BinaryProtocols::found() const {
  std::string_view text;
  std::uint32_t most = kOften - 1;
  for (std::size_t i = 0; i < kProtocols; ++i) {
    const bool has_end = kBinaryProtocols[i].end_mask != 0;
    const std::uint32_t count = has_end ? std::min(begun_[i], ended_[i]) : begun_[i];
    if (count <= most) continue;
    most = count;
    text = kBinaryProtocols[i].text;
  }
  return text;
}

}  // namespace rack::device

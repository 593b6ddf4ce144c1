// UBX, the binary protocol of u-blox receivers, used together with NMEA on the same line.
//
// A frame is B5 62, class, id, length (u16), payload, and a two byte Fletcher checksum over class
// to payload; numbers are little-endian. Between frames there may be NMEA sentences and RTCM 3
// corrections; the latter are skipped. Each configuration message is acknowledged (05 01) or
// refused (05 00).
//
// Source: u-blox interface descriptions of protocols 15 to 27; recordings of pyubx2.
#pragma once

#include "components/devices/positioning/gps.h"
#include "components/devices/positioning/nmea.h"

namespace rack::device {

struct UbxFrame {
  std::uint8_t class_id = 0;
  std::uint8_t number = 0;
  std::span<const std::byte> payload{};  // valid until the next call
  Time began{};

  [[nodiscard]] bool is(std::uint8_t of_class, std::uint8_t of_number) const {
    return class_id == of_class && number == of_number;
  }
};

namespace ubx {
inline constexpr std::uint8_t kNav = 0x01;
inline constexpr std::uint8_t kPvt = 0x07;
inline constexpr std::uint8_t kAck = 0x05;
inline constexpr std::uint8_t kRefused = 0x00;
inline constexpr std::uint8_t kAccepted = 0x01;
inline constexpr std::uint8_t kCfg = 0x06;
inline constexpr std::uint8_t kCfgPort = 0x00;
inline constexpr std::uint8_t kCfgMessage = 0x01;
inline constexpr std::uint8_t kCfgRate = 0x08;
inline constexpr std::uint8_t kCfgValues = 0x8A;
inline constexpr std::uint8_t kMon = 0x0A;
inline constexpr std::uint8_t kVersion = 0x04;
inline constexpr std::uint8_t kLayerRam = 1;

// Configuration keys of receivers since the ninth generation; the upper four bits encode the size.
inline constexpr std::uint32_t kBaudOfUart1 = 0x40520001;        // u32
inline constexpr std::uint32_t kUbxOutOfUart1 = 0x10740001;      // bool
inline constexpr std::uint32_t kPvtAtUart1 = 0x20910007;         // u8, every so many fixes
inline constexpr std::uint32_t kPvtAtUsb = 0x20910009;           // u8
inline constexpr std::uint32_t kMillisecondsOfFix = 0x30210001;  // u16
}  // namespace ubx

void append_ubx(std::vector<std::byte>& out, std::uint8_t class_id, std::uint8_t number,
                std::span<const std::byte> payload);
// Size of a value of CFG-VALSET by its key, bytes; 0: invalid key.
std::size_t ubx_value_size(std::uint32_t key);

// Decodes NAV-PVT; does not change recordingTime and pos. Returns false if the payload is invalid.
bool decode_ubx_pvt(std::span<const std::byte> payload, GpsData& data, GpsMoment& moment);

class UbxStream {
 public:
  enum class What : std::uint8_t { kNothing, kFrame, kSentence };

  // Maximum size of a piece; call next() until it returns nothing before adding more.
  static constexpr std::size_t kPieceMax = 1024;

  void add(const Arrival& arrival);
  // The result is valid until the next call.
  What next(UbxFrame& frame, NmeaSentence& sentence);
  void clear();

  [[nodiscard]] std::uint64_t frames() const { return frames_; }
  [[nodiscard]] std::uint64_t sentences() const { return sentences_; }
  // Number of frames with a wrong checksum, and of false starts of a frame.
  [[nodiscard]] std::uint64_t broken() const { return broken_; }
  // The start of an incomplete frame or sentence.
  [[nodiscard]] std::span<const std::byte> rest() const { return buffer_.bytes(); }

 private:
  // Longer frames exist only for raw measurements of very many satellites.
  static constexpr std::size_t kPayloadMax = 4096;
  static constexpr std::size_t kFrame = 8;
  static constexpr std::size_t kSentenceMax = 512;

  enum class Found : std::uint8_t { kNone, kPart, kWhole };
  Found find_frame(UbxFrame& frame);
  Found find_sentence(NmeaSentence& sentence);

  StreamBuffer buffer_{2 * (kPayloadMax + kFrame)};
  Time waits_since_{};  // since when the first frame or sentence has been incomplete
  bool is_part_ = false;
  std::size_t used_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t sentences_ = 0;
  std::uint64_t broken_ = 0;
};

}  // namespace rack::device

// Ibeo LD-A over CAN (1 Mbit/s, standard identifiers; the SICK LD-OEM has the same telegrams).
//
// The host sends with identifier 2A9, the scanner with 700 plus its id. A telegram with up to two
// bytes of data is one frame: 0000, 00 and the receiver, the service, the two bytes. A longer
// telegram starts with FFFF, the number of frames, the receiver and the service, followed by frames
// with a counter down to 1 and six bytes each. All big-endian. The service of an answer is that of
// the request plus 8000.
//
//   0102 status   0203 set the time   0301 send profiles   0302 stop profiles   0402 idle
//   0403 rotate   0404 measure
//
// A profile is one turn: its content (bits of the first 16 bit value), layers and sectors, then for
// each sector its step and first angle in 1/16 degree, number of points, time of begin and end in
// ms, distances in 1/256 m; at the end the status of the scanner.
//
// Source: RACK 0.6.1 ("User Protocol Services", Ibeo 2001); SICK, "LD-OEM1000 to LD-OEM5100:
// telegram listing".
#pragma once

#include <array>
#include <vector>

#include "rack/devices/device_clock.h"
#include "rack/devices/stream_buffer.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

namespace ibeo {
inline constexpr std::uint32_t kHostId = 0x2A9;
inline constexpr std::uint32_t kSensorId = 0x700;
inline constexpr std::uint8_t kHost = 1;

inline constexpr std::uint16_t kStatus = 0x0102;
inline constexpr std::uint16_t kSetTime = 0x0203;
inline constexpr std::uint16_t kProfiles = 0x0301;
inline constexpr std::uint16_t kNoProfiles = 0x0302;
inline constexpr std::uint16_t kIdle = 0x0402;
inline constexpr std::uint16_t kTurn = 0x0403;
inline constexpr std::uint16_t kMeasure = 0x0404;
inline constexpr std::uint16_t kAnswer = 0x8000;

inline constexpr unsigned kModeIdle = 1;
inline constexpr unsigned kModeTurning = 2;
inline constexpr unsigned kModeMeasuring = 3;
inline constexpr unsigned kModeError = 4;

// Bits for the content of a profile.
inline constexpr unsigned kHasNumber = 1 << 0;
inline constexpr unsigned kHasCount = 1 << 1;
inline constexpr unsigned kHasLayer = 1 << 2;
inline constexpr unsigned kHasSector = 1 << 3;
inline constexpr unsigned kHasStep = 1 << 4;
inline constexpr unsigned kHasPoints = 1 << 5;
inline constexpr unsigned kHasBegin = 1 << 6;
inline constexpr unsigned kHasFirstAngle = 1 << 7;
inline constexpr unsigned kHasDistance = 1 << 8;
inline constexpr unsigned kHasAngle = 1 << 9;
inline constexpr unsigned kHasEcho = 1 << 10;
inline constexpr unsigned kHasEnd = 1 << 11;
inline constexpr unsigned kHasLastAngle = 1 << 12;
inline constexpr unsigned kHasStatus = 1 << 13;
inline constexpr unsigned kWanted =
    kHasStep | kHasPoints | kHasBegin | kHasFirstAngle | kHasDistance | kHasEnd | kHasStatus;
}  // namespace ibeo

using IbeoFrame = std::array<std::byte, 8>;

// Appends the frames of a telegram to `receiver`.
void append_ibeo(std::vector<IbeoFrame>& out, std::uint8_t receiver, std::uint16_t service,
                 std::span<const std::byte> parameters);

struct IbeoTelegram {
  std::uint16_t service = 0;
  std::span<const std::byte> parameters{};  // padded by up to five bytes
  Time began{};                             // arrival of its first frame
};

// Assembles the telegrams to `receiver` from frames.
class IbeoTelegrams {
 public:
  explicit IbeoTelegrams(std::uint8_t receiver);

  // Returns true after the last frame of a telegram. The telegram is valid until the next call.
  bool take(const Arrival& frame, IbeoTelegram& telegram);
  void clear() { left_ = 0; }

  // Number of telegrams with a missing frame.
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  static constexpr std::size_t kLongest = 1 << 14;

  std::uint8_t receiver_;
  std::vector<std::byte> parameters_;
  std::uint16_t service_ = 0;
  unsigned left_ = 0;  // missing frames
  Time began_{};
  std::uint64_t broken_ = 0;
};

// Decodes a profile sector by sector.
class IbeoProfile {
 public:
  // begin() and next() return false if there is no (further) sector with points.
  bool begin(std::span<const std::byte> profile);
  // Converts a sector to a clockwise scan. begin, end: time of measurement by the scanner's clock,
  // ms.
  bool next(LadarData& scan, std::uint16_t& begin, std::uint16_t& end);

 private:
  [[nodiscard]] bool has(unsigned bit) const { return (format_ & bit) != 0; }
  [[nodiscard]] bool can_read(std::size_t bytes) const { return rest_.size() >= bytes; }
  unsigned take_u16();
  bool read_points(LadarData& scan, std::size_t points, unsigned first, unsigned step);

  std::span<const std::byte> rest_{};
  unsigned format_ = 0;
  unsigned sectors_ = 0;  // remaining sectors
};

struct IbeoSettings {
  std::uint8_t sensor = 1;
  bool only_listen = false;  // the device is a recording
};

class Ibeo final : public Dialogue {
 public:
  explicit Ibeo(const IbeoSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override {
    return std::min(timer_.due(), next_frame_at_);
  }
  [[nodiscard]] std::vector<CanFilter> wanted_frames() const override {
    return {{.id = ibeo::kSensorId | settings_.sensor, .mask = 0xC00007FF}};
  }

  [[nodiscard]] bool is_ready() const { return has_measured_; }
  // Each sector of a turn is a separate scan.
  bool take(LadarData& scan, Time& recorded);
  [[nodiscard]] std::uint64_t broken() const { return telegrams_.broken(); }

 private:
  // In the order of the setup.
  enum class State : std::uint8_t {
    kStatus,
    kQuiet,
    kTime,
    kTurn,
    kMeasure,
    kSpinUp,
    kProfiles,
    kMeasuring,
  };

  void enter(State state, Time now, Output& out);
  void ask(Time now, Output& out);
  void send_next(Time now, Output& out);
  void take_answer(const IbeoTelegram& telegram, Time now, Output& out);
  bool check_status(std::span<const std::byte> status);
  bool check_measure(std::span<const std::byte> answer);

  IbeoSettings settings_;
  State state_ = State::kStatus;
  Time spin_up_end_{};
  std::vector<IbeoFrame> frames_;  // frames of the current request
  std::size_t sent_ = 0;           // number of frames sent
  Time next_frame_at_ = tims::kNever;
  unsigned mode_ = 0;
  bool has_measured_ = false;  // a scan was received since start()
  IbeoTelegrams telegrams_{ibeo::kHost};
  std::vector<std::byte> bytes_;  // the profile whose sectors are being taken
  IbeoProfile profile_;
  Time came_{};
  DeviceClock clock_{std::chrono::milliseconds(1), 1ULL << 16};
};

}  // namespace rack::device

// Pan-tilt-zoom camera mounts with VISCA: Sony EVI and BRC, and most others, on a serial line (9600
// baud) or UDP port 52381.
//
// A message is an address byte (81 to the first camera, 90 from it, 88 to all), up to 14 bytes, FF.
// A command is acknowledged (4s) and completed later (5s), an inquiry is answered (50 ...); both
// may be refused (6s, reason). In UDP each message has a header of 8 bytes: kind, length (u16),
// sequence number (u32), big-endian; control message 01 resets the sequence numbers.
//
// Source: Sony's "EVI-D70 Command List" and "VISCA over IP" of the BRC-X series.
#pragma once

#include <optional>
#include <utility>

#include "components/devices/chassis/move_deadline.h"
#include "rack/devices/stream_buffer.h"
#include "rack/proxies/ptz_drive.h"

namespace rack::device {

namespace visca {
inline constexpr std::size_t kBytesMax = 16;
inline constexpr std::size_t kHeadBytes = 8;  // UDP header
inline constexpr std::byte kEnd{0xFF};

enum class Kind : std::uint16_t {
  kCommand = 0x0100,
  kQuestion = 0x0110,
  kReply = 0x0111,
  kControl = 0x0200,
  kControlReply = 0x0201,
};

// Appends a number as four bytes of four bits each.
void append_nibbles(std::vector<std::byte>& out, int number);
int nibbles(std::span<const std::byte> bytes);
// Appends a message with its UDP header.
void append_datagram(std::vector<std::byte>& out, Kind kind, std::uint32_t number,
                     std::span<const std::byte> message);

// The commands that stop the first camera of a serial line, in any state.
std::vector<std::byte> stand();

struct Datagram {
  Kind kind{};
  std::uint32_t number = 0;
  std::span<const std::byte> message{};
};
std::optional<Datagram> parse_datagram(std::span<const std::byte> bytes);
}  // namespace visca

// Splits a stream into messages. Anything longer than the longest message is noise.
class ViscaMessages {
 public:
  void add(const Arrival& arrival) { buffer_.add(arrival); }
  // Includes the end byte; valid until the next call.
  std::optional<std::span<const std::byte>> next();
  void clear() { buffer_.clear(); }

 private:
  StreamBuffer buffer_{256};
  std::size_t used_ = 0;
};

struct ViscaSettings {
  bool is_datagrams = false;
  bool only_listen = false;  // the device is a recording
  Duration period = std::chrono::milliseconds(100);
  Duration move_deadline{};       // validity of move(); 0: three periods of the caller
  double steps_of_degree = 14.4;  // pan and tilt; EVI-D70: 13.33
  double zoom_max = 0x4000;       // zoom value for 100 %
  double pan_speed_max = 100;     // deg/s at the highest step of speed
  double tilt_speed_max = 100;
  double zoom_speed_max = 50;  // %/s
};

class Visca final : public Dialogue {
 public:
  explicit Visca(const ViscaSettings& settings)
      : settings_(settings), deadline_(settings.move_deadline) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;
  [[nodiscard]] std::vector<Telegram> stop_commands() const override;
  [[nodiscard]] Time next_timeout() const override;

  // Commands are sent at the next on_timeout(), which is due at once.
  void home();
  void move_to(const PtzDriveMovePosData& move);
  // Moves until the command expires without a repetition (move_deadline.h).
  void move(const PtzDriveMoveVelData& move, Time now);

  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(PtzDriveData& data, Time& recorded);
  // True once when the position of the last move_to() is reached.
  bool take_reached();
  // True once after each stop because the last move() had expired.
  bool take_overdue() { return std::exchange(overdue_, false); }
  // Number of messages refused by the camera since start().
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  enum class Asked : std::uint8_t { kNothing, kBegin, kPanTilt, kZoom };
  struct Target {
    int pan = 0;
    int tilt = 0;
    int zoom = 0;
  };

  void send(visca::Kind kind, std::span<const std::byte> message, Output& out);
  void ask(Asked what, Time now, Output& out);
  void begin(Output& out);
  void send_commands(Output& out);
  void on_message(std::span<const std::byte> message, Time when, Output& out);
  void on_answer(std::span<const std::byte> body, Time when, Output& out);
  [[nodiscard]] int speed(double velocity, double velocity_max, int steps) const;
  void turn(int pan, int tilt, int zoom);  // steps of speed
  void queue(std::span<const std::byte> command);

  ViscaSettings settings_;
  MoveDeadline deadline_;
  bool overdue_ = false;
  ViscaMessages messages_;
  Asked asked_ = Asked::kNothing;
  Time next_question_{};
  std::uint32_t number_ = 0;
  std::vector<std::byte> commands_;  // queue of messages
  std::vector<std::byte> sending_;
  Target now_{};
  std::optional<Target> target_;
  bool is_ready_ = false;
  bool is_reached_ = false;
  bool has_data_ = false;
  PtzDriveData data_{};
  Time recorded_{};
  std::uint64_t refused_ = 0;
};

}  // namespace rack::device

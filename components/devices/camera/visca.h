// Camera mounts that speak VISCA: Sony EVI and BRC, and most others that pan, tilt and zoom, at a
// serial line (9600 baud) or at UDP port 52381.
//
// A message is its way (81 to the first camera, 90 from it, 88 to all), up to 14 bytes, FF. A
// command is acknowledged (4s) and completed later (5s), a question is answered (50 ...), either
// may be refused (6s, why). In UDP each message has a head of 8 bytes: kind, length (u16),
// sequence number (u32), big-endian; control message 01 sets the numbers back.
//
// Source: Sony's "EVI-D70 Command List" and "VISCA over IP" of the BRC-X series.
#pragma once

#include <optional>
#include <utility>

#include "components/devices/chassis/move_deadline.h"
#include "components/devices/core/stream_buffer.h"
#include "rack/proxies/ptz_drive.h"

namespace rack::device {

namespace visca {
inline constexpr std::size_t kBytesMax = 16;
inline constexpr std::size_t kHeadBytes = 8;  // in UDP
inline constexpr std::byte kEnd{0xFF};

enum class Kind : std::uint16_t {
  kCommand = 0x0100,
  kQuestion = 0x0110,
  kReply = 0x0111,
  kControl = 0x0200,
  kControlReply = 0x0201,
};

// Numbers are four bytes of four bits each.
void append_nibbles(std::vector<std::byte>& out, int number);
int nibbles(std::span<const std::byte> bytes);
// With its head.
void append_datagram(std::vector<std::byte>& out, Kind kind, std::uint32_t number,
                     std::span<const std::byte> message);

// What makes the first camera of a serial line stand, whatever it does.
std::vector<std::byte> stand();

struct Datagram {
  Kind kind{};
  std::uint32_t number = 0;
  std::span<const std::byte> message{};
};
std::optional<Datagram> parse_datagram(std::span<const std::byte> bytes);
}  // namespace visca

// Messages out of a stream. What is longer than any message is noise.
class ViscaMessages {
 public:
  void add(const Arrival& arrival) { buffer_.add(arrival); }
  // With its end; valid until the next call.
  std::optional<std::span<const std::byte>> next();
  void clear() { buffer_.clear(); }

 private:
  StreamBuffer buffer_{256};
  std::size_t used_ = 0;
};

struct ViscaSettings {
  bool is_datagrams = false;
  bool only_listen = false;  // to a recording
  Duration period = std::chrono::milliseconds(100);
  Duration move_deadline{};       // of move(); 0: three periods of who calls it
  double steps_of_degree = 14.4;  // of pan and tilt; EVI-D70: 13.33
  double zoom_max = 0x4000;       // what is 100 %
  double pan_speed_max = 100;     // deg/s, of its highest step of speed
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
  [[nodiscard]] std::vector<Telegram> last_words() const override;
  [[nodiscard]] Time next_timeout() const override;

  // They are sent at the next on_timeout(), which is due at once.
  void home();
  void move_to(const PtzDriveMovePosData& move);
  // Until nobody has said it again in time (move_deadline.h).
  void move(const PtzDriveMoveVelData& move, Time now);

  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(PtzDriveData& data, Time& recorded);
  // Once, when the place of the last move_to() is reached.
  bool take_reached();
  // It was stopped because nobody said move() again. True once for each time.
  bool take_overdue() { return std::exchange(overdue_, false); }
  // What the camera did not want, since start().
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
  int attempts_ = 0;
  Time timeout_ = tims::kNever;
  Time next_question_{};
  std::uint32_t number_ = 0;
  std::vector<std::byte> commands_;  // one after the other
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

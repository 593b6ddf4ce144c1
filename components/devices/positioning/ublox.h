// A u-blox receiver: found at whatever rate its line has, told to send its fixes as NAV-PVT, and
// listened to.
//
// Receivers up to the eighth generation begin at 9600 baud, later ones at 38400; somebody may have
// changed it. At each rate it is listened for a second and asked for its version. Then it is set:
// with CFG-VALSET, which receivers since the ninth generation know; one that refuses it, or does
// not answer, is set with the messages of older ones. Nothing is stored: after power off it is as
// it was. Until the first NAV-PVT has come, and of recordings without any, its NMEA sentences
// count.
#pragma once

#include "components/devices/positioning/nmea_receiver.h"
#include "components/devices/positioning/ubx.h"

namespace rack::device {

struct UbloxSettings {
  std::uint32_t baud = 0;  // to bring the line to; 0: as it is found
  Duration period = std::chrono::seconds(1);
  bool only_listen = false;  // to a recording
};

class Ublox final : public Dialogue {
 public:
  explicit Ublox(const UbloxSettings& settings)
      : settings_(settings), nmea_({.period = settings.period, .only_listen = true}) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return timeout_; }

  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(GpsData& data, Time& recorded);
  // Of what was taken last.
  [[nodiscard]] const GpsMoment& moment() const { return taken_; }
  [[nodiscard]] Time recorded() const { return recorded_; }
  [[nodiscard]] const UbxStream& stream() const { return stream_; }
  [[nodiscard]] std::uint64_t broken() const { return stream_.broken(); }
  // It was set with the messages of receivers up to the eighth generation.
  [[nodiscard]] bool is_old() const { return is_old_; }

 private:
  // In the order in which they are gone through.
  enum class State : std::uint8_t { kFind, kSetRate, kVerifyRate, kSetFix, kSetMessage, kListen };

  void find_at(std::size_t rate, Time now, Output& out);
  void found(Time now, Output& out);
  void enter(State state, Time now, Output& out);
  void ask(Time now, Output& out);
  void ask_values(State state);
  void ask_old(State state);
  void on_frame(const UbxFrame& frame, Output& out);
  void on_answer(bool accepted, Time now, Output& out);
  void on_silence(Time now, Output& out);
  void take_pvt(const UbxFrame& frame);
  void take_nmea();
  [[nodiscard]] std::vector<std::uint32_t> rates() const;

  UbloxSettings settings_;
  UbxStream stream_;
  NmeaReceiver nmea_;
  State state_ = State::kFind;
  std::size_t rate_ = 0;  // of rates(), that the line has now
  std::vector<std::uint32_t> rates_;
  int attempts_ = 0;
  int rate_tries_ = 0;
  bool is_old_ = false;
  bool has_pvt_ = false;
  bool is_ready_ = false;
  Time timeout_ = tims::kNever;
  std::uint8_t asked_ = 0;  // number of the class CFG that waits for an acknowledgement
  std::vector<std::byte> question_;
  std::vector<std::byte> payload_;
  bool has_data_ = false;
  GpsData data_{};
  GpsMoment moment_{};
  GpsMoment taken_{};
  Time measured_{};
  Time recorded_{};
};

}  // namespace rack::device

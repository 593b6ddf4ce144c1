// A u-blox receiver: the dialogue detects its baud rate and configures it to send fixes as NAV-PVT.
//
// Receivers up to the eighth generation start at 9600 baud, later ones at 38400, unless configured
// otherwise. At each rate, the dialogue listens for one second and requests the version. It then
// configures the receiver with CFG-VALSET, known since the ninth generation; a receiver that
// refuses it or does not answer is configured with the older messages. The configuration is not
// stored: it is lost at power-off. NMEA sentences are used until the first NAV-PVT, and in
// recordings without it.
#pragma once

#include "components/devices/positioning/nmea_receiver.h"
#include "components/devices/positioning/ubx.h"

namespace rack::device {

struct UbloxSettings {
  std::uint32_t baud = 0;  // rate to set; 0: keep the detected rate
  Duration period = std::chrono::seconds(1);
  bool only_listen = false;  // the device is a recording
};

class Ublox final : public Dialogue {
 public:
  explicit Ublox(const UbloxSettings& settings)
      : settings_(settings), nmea_({.period = settings.period, .only_listen = true}) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(GpsData& data, Time& recorded);
  // The time of the data taken last.
  [[nodiscard]] const GpsMoment& moment() const { return taken_; }
  [[nodiscard]] Time recorded() const { return recorded_; }
  [[nodiscard]] const UbxStream& stream() const { return stream_; }
  [[nodiscard]] std::uint64_t broken() const { return stream_.broken(); }
  // The receiver was configured with the messages of the eighth generation and earlier.
  [[nodiscard]] bool is_old() const { return is_old_; }

 private:
  // In the order of the setup.
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
  std::size_t rate_ = 0;  // index in rates() of the current rate
  std::vector<std::uint32_t> rates_;
  int rate_tries_ = 0;
  bool is_old_ = false;
  bool has_pvt_ = false;
  bool is_ready_ = false;
  std::uint8_t asked_ = 0;  // CFG message that waits for an acknowledgement
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

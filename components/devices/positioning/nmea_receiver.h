// A satellite receiver that sends NMEA 0183 without requests; GpsNmea sends nothing to it.
//
// A data set begins with the sentence of trigMsgStart and ends with that of trigMsgEnd. If both are
// the same (mostly RMC), each such sentence gives a data set, completed by the latest values of the
// others. For receivers that do not send it, the first sentence with a position that has arrived
// four times is used instead.
#pragma once

#include "components/devices/positioning/binary_protocols.h"
#include "components/devices/positioning/nmea_fix.h"

namespace rack::device {

struct NmeaSettings {
  NmeaKind start = NmeaKind::kRmc;
  NmeaKind end = NmeaKind::kRmc;
  Duration period = std::chrono::seconds(1);
  GpsDeviations deviations{};
  std::uint32_t baud = 4800;  // for error messages only
  bool only_listen = false;   // the device is a recording: pauses are not failures
};

class NmeaReceiver final : public Dialogue {
 public:
  explicit NmeaReceiver(const NmeaSettings& settings)
      : settings_(settings), fix_(settings.deviations) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

  // A data set was received; from then on, missing data are an error of the driver.
  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(GpsData& data, Time& recorded);
  // The time of the data taken last.
  [[nodiscard]] const GpsMoment& moment() const { return taken_; }
  [[nodiscard]] Time recorded() const { return recorded_; }
  [[nodiscard]] const NmeaLines& lines() const { return lines_; }
  [[nodiscard]] std::uint64_t broken() const { return lines_.broken(); }

  // Why there was no data set, as far as the received bytes show it.
  [[nodiscard]] std::string why_silent() const;

  // Adds a sentence that was received together with another protocol.
  void add(const NmeaSentence& sentence);

 private:
  void count_position(NmeaKind kind, Time began);
  [[nodiscard]] std::string why_no_sentence() const;
  void publish();

  NmeaSettings settings_;
  NmeaLines lines_;
  BinaryProtocols binary_;
  NmeaFix fix_;
  std::optional<NmeaKind> instead_;  // replaces start and end if they are not received
  std::array<int, kNmeaKinds> since_end_{};
  bool has_begun_ = false;
  bool start_comes_ = false;  // the sentence of trigMsgStart was received
  bool is_ready_ = false;
  Time begun_{};
  std::uint64_t bytes_ = 0;
  bool has_data_ = false;
  GpsData data_{};
  GpsMoment moment_{};
  GpsMoment taken_{};
  Time recorded_{};
};

}  // namespace rack::device

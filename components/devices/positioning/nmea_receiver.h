// A satellite receiver that talks NMEA 0183 by itself: GpsNmea listens and never asks.
//
// A data set begins with the sentence that trigMsgStart names, and ends with trigMsgEnd; if both
// are the same (RMC in most cases), each of these is one, completed by what the others have said
// last. A receiver that does not send it is listened to all the same: the first sentence with a
// position that has come four times meanwhile takes its place.
#pragma once

#include "components/devices/positioning/nmea_fix.h"

namespace rack::device {

struct NmeaSettings {
  NmeaKind start = NmeaKind::kRmc;
  NmeaKind end = NmeaKind::kRmc;
  Duration period = std::chrono::seconds(1);
  GpsDeviations deviations{};
  std::uint32_t baud = 4800;  // for words only
  bool only_listen = false;   // to a recording: silence is no failure
};

class NmeaReceiver final : public Dialogue {
 public:
  explicit NmeaReceiver(const NmeaSettings& settings)
      : settings_(settings), fix_(settings.deviations) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return timeout_; }

  // It has sent a data set; from then on the driver watches for silence.
  [[nodiscard]] bool is_ready() const { return is_ready_; }
  bool take(GpsData& data, Time& recorded);
  // Of what was taken last.
  [[nodiscard]] const GpsMoment& moment() const { return taken_; }
  [[nodiscard]] Time recorded() const { return recorded_; }
  [[nodiscard]] const NmeaLines& lines() const { return lines_; }
  [[nodiscard]] std::uint64_t broken() const { return lines_.broken(); }

  // Sentences that came on another way, beside another protocol.
  void add(const NmeaSentence& sentence);

 private:
  void count_position(NmeaKind kind, Time began);
  void publish();

  NmeaSettings settings_;
  NmeaLines lines_;
  NmeaFix fix_;
  std::optional<NmeaKind> instead_;  // of the start and end that never come
  std::array<int, kNmeaKinds> since_end_{};
  bool has_begun_ = false;
  bool start_comes_ = false;  // the one that was asked for
  bool is_ready_ = false;
  Time begun_{};
  Time timeout_ = tims::kNever;
  std::uint64_t bytes_ = 0;
  bool has_data_ = false;
  GpsData data_{};
  GpsMoment moment_{};
  GpsMoment taken_{};
  Time recorded_{};
};

}  // namespace rack::device

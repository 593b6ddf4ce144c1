// A dialogue and the way to its device, brought together: waits, hands over what came, sends what
// is to be sent, keeps a capture of both.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "components/devices/core/conversation.h"
#include "components/devices/io/guard.h"
#include "components/devices/io/transport.h"
#include "components/files/capture_file.h"

namespace rack::device {

struct DeviceOptions {
  DeviceAddress address{};
  std::uint32_t baud = 115200;  // where the address says none
  std::string record{};         // path of a capture; empty: none
};

class Device final : private Output {
 public:
  // Its error is that of wait().
  using Take = Conversation::Take;

  // Opens it and starts the dialogue, which must outlive it.
  static tims::Result<std::unique_ptr<Device>> open(const DeviceOptions& options,
                                                    Dialogue& dialogue, Take take = {});
  // The same with a way of one's own.
  static std::unique_ptr<Device> with(std::unique_ptr<Transport> transport,
                                      std::unique_ptr<CaptureFile> capture, Dialogue& dialogue,
                                      Take take = {});
  ~Device() override;

  // Until something came, a time of the dialogue has passed, `also` can be read, or `until`. An
  // error says why the device has to be opened again: it is gone, or the dialogue gave it up.
  tims::Result<void> wait(Time until, int also = -1);

  // For who waits for several at once, and calls wait() with a time that is past: when this can be
  // read, or at this time.
  [[nodiscard]] int descriptor() const { return transport_->descriptor(); }
  [[nodiscard]] Time next_timeout() const {
    return std::min(dialogue_.next_timeout(), transport_->next_timeout());
  }

  [[nodiscard]] std::string description() const { return transport_->description(); }
  // Data that were taken, for the recording: a replay has to make them again.
  void note_made(Time measured, std::span<const std::byte> message);
  [[nodiscard]] bool is_recorded() const { return capture_ != nullptr; }
  // As those of the transport, and of the recording.
  std::optional<std::string> take_event();
  // The dialogue says its last words, and the recording is finished: only events can be asked then.
  void close();
  [[nodiscard]] std::string statistics() const { return transport_->statistics(); }
  // It is a recording; and at its end.
  [[nodiscard]] bool is_recording() const { return transport_->is_recording(); }
  [[nodiscard]] bool is_over() const { return transport_->is_over(); }

 private:
  Device(std::unique_ptr<Transport> transport, std::unique_ptr<CaptureFile> capture,
         Dialogue& dialogue, Take take);

  void send(std::span<const std::byte> bytes, std::uint32_t id) override {
    send_before(tims::kNever, bytes, id);
  }
  void send_before(Time deadline, std::span<const std::byte> bytes, std::uint32_t id) override;
  void set_baud(std::uint32_t baud) override;
  void set_dtr(bool on) override { transport_->set_dtr(on); }
  void hand_over(const Arrival& arrival);
  void note(Time when, Direction direction, const Arrival& arrival = {});
  tims::Result<void> state();

  std::unique_ptr<Transport> transport_;
  std::unique_ptr<CaptureFile> capture_;  // or none
  std::unique_ptr<Guard> guard_;          // or none
  Dialogue& dialogue_;
  const Transport::Receive receive_;
  Conversation conversation_;
  std::optional<tims::Error> lost_;  // while sending
  std::uint32_t records_ = 0;        // of what the dialogue has heard
  bool is_closed_ = false;
};

}  // namespace rack::device

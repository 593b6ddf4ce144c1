// Connects a dialogue with the transport to its device: waits, passes received data to the
// dialogue, sends its output, and records both.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rack/devices/capture.h"
#include "rack/devices/conversation.h"
#include "rack/devices/transport.h"

#pragma GCC visibility push(default)  // exported by librack-devices.so
namespace rack::device {

class CaptureFile;
class Guard;

struct DeviceOptions {
  DeviceAddress address{};
  std::uint32_t baud = 115200;  // used if the address has no option baud
  std::string record{};         // path of the capture to write; empty: none
  // &open_dcam in programs that are linked to libdc1394; without it, dcam: is refused.
  tims::Result<std::unique_ptr<Transport>> (*open_dcam)(const DeviceAddress& address) = nullptr;
};

class Device final : private Output {
 public:
  // wait() returns the error of this function.
  using Take = Conversation::Take;

  // Opens the device and starts the dialogue, which must outlive this object.
  static tims::Result<std::unique_ptr<Device>> open(const DeviceOptions& options,
                                                    Dialogue& dialogue, Take take = {});
  // The same with a transport created by the caller, without or with a recording.
  static std::unique_ptr<Device> with(std::unique_ptr<Transport> transport, Dialogue& dialogue,
                                      Take take = {});
  static std::unique_ptr<Device> with(std::unique_ptr<Transport> transport,
                                      std::unique_ptr<CaptureFile> capture, Dialogue& dialogue,
                                      Take take = {});
  ~Device() override;

  // Waits until data was received, a timeout of the dialogue has passed, `also` is readable, or
  // `until`. After an error the device must be opened again: it was lost, or the dialogue has given
  // it up.
  tims::Result<void> wait(Time until, int also = -1);

  // For callers that wait for several devices: they call wait() with a time in the past when
  // descriptor() is readable or at next_timeout().
  [[nodiscard]] int descriptor() const { return transport_->descriptor(); }
  [[nodiscard]] Time next_timeout() const {
    return std::min(dialogue_.next_timeout(), transport_->next_timeout());
  }

  [[nodiscard]] std::string description() const { return transport_->description(); }
  // Records a data set for the comparison in a replay.
  void note_made(Time measured, std::span<const std::byte> message);
  [[nodiscard]] bool is_recorded() const { return capture_ != nullptr; }
  // Events of the transport and of the recording; see Transport::take_event().
  std::optional<std::string> take_event();
  // Stops the dialogue and finishes the recording. After that, only take_event() may be called.
  void close();
  [[nodiscard]] std::string statistics() const { return transport_->statistics(); }
  // Whether the device is a recording, and whether its end was reached.
  [[nodiscard]] bool is_recording() const { return transport_->is_recording(); }
  [[nodiscard]] bool is_over() const { return transport_->is_over(); }
  [[nodiscard]] Duration pause_max() const { return transport_->pause_max(); }

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
  std::unique_ptr<CaptureFile> capture_;  // may be null
  std::unique_ptr<Guard> guard_;          // may be null
  Dialogue& dialogue_;
  const Transport::Receive receive_;
  Conversation conversation_;
  std::optional<tims::Error> lost_;  // error while sending
  std::uint32_t records_ = 0;        // inputs passed to the dialogue
  bool is_closed_ = false;
};

}  // namespace rack::device

#pragma GCC visibility pop

// Interface of all transports to a device. One suite of tests, transport_contract_test, verifies
// the contract for all of them.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rack/devices/device_address.h"
#include "rack/devices/dialogue.h"

#pragma GCC visibility push(default)  // exported by librack-devices.so
namespace rack::device {

// Not thread-safe. Callers wait with poll() on the descriptor.
class Transport {
 public:
  using Receive = std::function<void(const Arrival&)>;

  virtual ~Transport() = default;

  // Readable when there is something to receive.
  [[nodiscard]] virtual int descriptor() const = 0;
  // receive() must also be called at this time, even if the descriptor is not readable.
  [[nodiscard]] virtual Time next_timeout() const { return tims::kNever; }
  // Passes all data received so far to `receive`, in order. An error means that the device was lost
  // and must be opened again; its text states the reason.
  virtual tims::Result<void> receive(Time now, const Receive& receive) = 0;
  // Returns whether the data was accepted: if the device reads too slowly, whole pieces are
  // dropped, never parts of them. An error as above.
  virtual tims::Result<bool> send(Time now, std::span<const std::byte> bytes, std::uint32_t id) = 0;
  // On CAN, the frame is dropped if it could not be sent before the deadline.
  virtual tims::Result<bool> send_before(Time now, Time /*deadline*/,
                                         std::span<const std::byte> bytes, std::uint32_t id) {
    return send(now, bytes, id);
  }

  // The bytes another process must write to a copy of the descriptor to send these telegrams: each
  // element by one write(), on streams by one or more.
  [[nodiscard]] virtual std::vector<std::vector<std::byte>> to_write(
      const std::vector<Telegram>& telegrams) const;

  virtual void set_baud(std::uint32_t /*baud*/) {}
  virtual void set_dtr(bool /*on*/) {}
  // A message for the log about an event since the last call, for example "can0 is bus-off".
  virtual std::optional<std::string> take_event() { return {}; }
  // Text with the error counts so far; empty if there were no errors.
  [[nodiscard]] virtual std::string statistics() const { return {}; }
  // For the log: address and detected properties of the device.
  [[nodiscard]] virtual std::string description() const = 0;
  // is_recording: output is discarded. is_over: the end of the recording was reached.
  [[nodiscard]] virtual bool is_recording() const { return false; }
  [[nodiscard]] virtual bool is_over() const { return false; }
  // A longer silence than this may be a fault, whatever the period of the device is.
  [[nodiscard]] virtual Duration pause_max() const { return std::chrono::milliseconds(200); }
};

// `baud`: rate of serial lines if the address has no option baud. `wanted`: CAN filters. The text
// of kSystem states what is missing (rights, a kernel module, a cable) and what to do.
tims::Result<std::unique_ptr<Transport>> open_transport(const DeviceAddress& address,
                                                        std::uint32_t baud,
                                                        const std::vector<CanFilter>& wanted = {
                                                            CanFilter{}});

}  // namespace rack::device

#pragma GCC visibility pop

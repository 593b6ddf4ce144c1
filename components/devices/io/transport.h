// The ways to a device: what all of them promise is one suite of tests (transport_contract_test).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "components/devices/core/device_address.h"
#include "components/devices/core/dialogue.h"

namespace rack::device {

// Not for several threads. Whatever it waits for, it waits in poll() on its descriptor.
class Transport {
 public:
  using Receive = std::function<void(const Arrival&)>;

  virtual ~Transport() = default;

  // To be waited for until it can be read.
  [[nodiscard]] virtual int descriptor() const = 0;
  // There may be something to read at this time without the descriptor saying so.
  [[nodiscard]] virtual Time next_timeout() const { return tims::kNever; }
  // All that is there now, in order. An error: the device is gone, in words; open it again.
  virtual tims::Result<void> receive(Time now, const Receive& receive) = 0;
  // Whether it has taken all of it: a device that reads slower than it is told to loses whole
  // pieces, never halves. An error as above.
  virtual tims::Result<bool> send(Time now, std::span<const std::byte> bytes, std::uint32_t id) = 0;
  // Of CAN: it is dropped when it could not be sent until then.
  virtual tims::Result<bool> send_before(Time now, Time /*deadline*/,
                                         std::span<const std::byte> bytes, std::uint32_t id) {
    return send(now, bytes, id);
  }

  // What somebody else would write to a copy of the descriptor to send these: each piece by one
  // write(), or by several where it is a stream.
  [[nodiscard]] virtual std::vector<std::vector<std::byte>> to_write(
      const std::vector<Telegram>& telegrams) const;

  virtual void set_baud(std::uint32_t /*baud*/) {}
  virtual void set_dtr(bool /*on*/) {}
  // What has happened to the line since it was asked last, for people: "can0 has left the bus".
  virtual std::optional<std::string> take_event() { return {}; }
  // What has gone wrong so far, counted; empty: nothing.
  [[nodiscard]] virtual std::string statistics() const { return {}; }
  // For the log: how the device is reached, and what was found out about it.
  [[nodiscard]] virtual std::string description() const = 0;
  // Nobody hears what is sent; is_over: and nothing more comes.
  [[nodiscard]] virtual bool is_recording() const { return false; }
  [[nodiscard]] virtual bool is_over() const { return false; }
};

// `baud`: of serial lines whose address does not say any. `wanted`: of CAN. kSystem says what is
// missing, and what to do: rights, a module of the kernel, a cable.
tims::Result<std::unique_ptr<Transport>> open_transport(const DeviceAddress& address,
                                                        std::uint32_t baud,
                                                        const std::vector<CanFilter>& wanted = {
                                                            CanFilter{}});

}  // namespace rack::device

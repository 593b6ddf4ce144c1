// Transport of raw CAN frames by SocketCAN.
//
// Error frames of the controller arrive as frames with the error flag, independent of the filters.
// Frames that cannot be sent at once wait in a small queue (CanQueue) for at most 100 ms.
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <map>

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include "components/devices/core/can_bus.h"
#include "components/devices/io/can_link.h"
#include "components/devices/io/stamped.h"
#include "components/devices/io/transports.h"
#include "os/clock.h"
#include "os/file.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;
using tims::os::File;
using tims::os::system_error;

constexpr Duration kLate = std::chrono::milliseconds(100);
constexpr Duration kCanTryAgain = std::chrono::milliseconds(1);

// State that outlives a transport: a driver that closes its bus and opens it again must not forget
// how often it went bus-off. Not thread-safe: only one task of a program opens interfaces.
CanBus& bus_of(const std::string& name) {
  static std::map<std::string, CanBus> buses;
  return buses.try_emplace(name, name).first->second;
}

can_frame frame_of(std::uint32_t id, std::span<const std::byte> bytes) {
  can_frame frame{};
  frame.can_id = id;
  frame.can_dlc = static_cast<std::uint8_t>(std::min<std::size_t>(bytes.size(), CAN_MAX_DLEN));
  std::memcpy(frame.data, bytes.data(), frame.can_dlc);
  return frame;
}

class CanInterface final : public Transport {
 public:
  CanInterface(File socket, std::string name, unsigned index)
      : socket_(std::move(socket)), name_(std::move(name)), index_(index), bus_(bus_of(name_)) {
    bus_.on_open(tims::os::now());
  }

  [[nodiscard]] int descriptor() const override { return socket_.get(); }
  [[nodiscard]] Time next_timeout() const override {
    return std::min(next_try_, bus_.next_restart());
  }
  std::optional<std::string> take_event() override { return std::exchange(event_, {}); }
  [[nodiscard]] std::string statistics() const override { return bus_.summary(); }
  [[nodiscard]] std::string description() const override { return name_; }

  Result<void> receive(Time now, const Receive& receive) override {
    if (bus_.next_restart() <= now) restart(now);
    if (const auto why = bus_.failure(now)) return Error(Errc::kSystem, *why);
    if (auto written = write_waiting(now); !written) return written;
    constexpr int kAtOnce = 256;  // limits the time in this function on a busy bus
    for (int i = 0; i < kAtOnce; ++i) {
      can_frame frame{};
      socklen_t none = 0;
      const auto got = receive_stamped(socket_.get(), std::as_writable_bytes(std::span(&frame, 1)),
                                       nullptr, none);
      if (!got) return Error(Errc::kSystem, name_ + " is gone: " + got.error().detail());
      if (!got->is_there) return {};
      const std::size_t size = std::min<std::size_t>(frame.can_dlc, CAN_MAX_DLEN);
      on_bus(frame, size, now);
      receive({.bytes = std::as_bytes(std::span(frame.data)).first(size),
               .first = got->when,
               .last = got->when,
               .id = frame.can_id});
    }
    return {};
  }

  Result<bool> send(Time now, std::span<const std::byte> bytes, std::uint32_t id) override {
    return send_before(now, now + kLate, bytes, id);
  }
  Result<bool> send_before(Time now, Time deadline, std::span<const std::byte> bytes,
                           std::uint32_t id) override {
    if (!waiting_.add(id, bytes, std::min(deadline, now + kLate))) return false;
    if (auto written = write_waiting(now); !written) return written.error();
    return true;
  }
  // One frame per write().
  [[nodiscard]] std::vector<std::vector<std::byte>> to_write(
      const std::vector<Telegram>& telegrams) const override {
    std::vector<std::vector<std::byte>> pieces;
    for (const Telegram& telegram : telegrams) {
      const can_frame frame = frame_of(telegram.id, telegram.bytes);
      const auto bytes = std::as_bytes(std::span(&frame, 1));
      pieces.emplace_back(bytes.begin(), bytes.end());
    }
    return pieces;
  }

 private:
  void on_bus(const can_frame& frame, std::size_t size, Time now) {
    if ((frame.can_id & CAN_ERR_FLAG) == 0) {
      bus_.on_frame();
      return;
    }
    auto event =
        bus_.on_error_frame(frame.can_id, std::as_bytes(std::span(frame.data)).first(size), now);
    if (event) event_ = std::move(event);
  }

  // Discards waiting frames: motors must not receive outdated commands.
  void restart(Time now) {
    waiting_.clear();
    bus_.on_restart(now);
    if (auto done = restart_can(index_); !done && !event_)
      event_ = name_ + " cannot be restarted after bus-off: " + done.error().detail();
  }

  Result<void> write_waiting(Time now) {
    bus_.on_late(waiting_.drop_late(now));
    while (!waiting_.empty()) {
      const CanQueue::Frame& next = waiting_.front();
      const can_frame frame = frame_of(next.id, std::span(next.bytes).first(next.size));
      if (::write(socket_.get(), &frame, sizeof frame) != sizeof frame) {
        if (errno == EINTR) continue;
        // The interface's queue is short (10 frames by default), so a full queue is normal.
        if (errno == ENOBUFS || errno == EAGAIN) break;
        return Error(Errc::kSystem, name_ + " is gone: " + system_error("write").detail());
      }
      waiting_.pop();
    }
    next_try_ = waiting_.empty() ? tims::kNever : now + kCanTryAgain;
    return {};
  }

  File socket_;
  std::string name_;
  unsigned index_;
  CanBus& bus_;
  std::optional<std::string> event_;
  CanQueue waiting_;
  Time next_try_ = tims::kNever;
};

}  // namespace

Result<std::unique_ptr<Transport>> open_can(const DeviceAddress& address,
                                            const std::vector<CanFilter>& wanted) {
  const std::string& name = address.place;
  File socket(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (!socket)
    return Error(Errc::kSystem, system_error("CAN sockets").detail() + "; modprobe can_raw");
  const unsigned index = ::if_nametoindex(name.c_str());
  if (index == 0)
    return Error(Errc::kSystem,
                 "no interface " + name + "; to list interfaces: ip link, timsctl device list");
  const can_err_mask_t errors = CAN_ERR_MASK;
  ::setsockopt(socket.get(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors);
  std::vector<can_filter> filters;
  filters.reserve(wanted.size());
  for (const CanFilter& filter : wanted)
    filters.push_back({.can_id = filter.id, .can_mask = filter.mask});
  if (::setsockopt(socket.get(), SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                   static_cast<socklen_t>(filters.size() * sizeof(can_filter))) != 0)
    return system_error(name + ", filters");
  ask_for_stamps(socket.get());
  sockaddr_can where{};
  where.can_family = AF_CAN;
  where.can_ifindex = static_cast<int>(index);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&where), sizeof where) != 0)
    return system_error(name);
  return std::unique_ptr<Transport>(std::make_unique<CanInterface>(std::move(socket), name, index));
}

}  // namespace rack::device

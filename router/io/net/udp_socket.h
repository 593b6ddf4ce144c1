// A UDP socket that sends bursts of datagrams in one call (UDP_SEGMENT), takes many in one
// (recvmmsg, UDP_GRO), and does not fragment them unless asked to. Whoever owns it waits for fd()
// in the loop.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "os/file.h"
#include "router/config/config.h"
#include "router/link/transport.h"
#include "tims/result.h"

namespace tims::io {

// What arrives: up to 16 slots in one call, each with many datagrams of one sender where the kernel
// puts them together. The memory is allocated once.
class Datagrams {
 public:
  static constexpr std::size_t kSlots = 16;
  static constexpr std::size_t kSlotBytes = 64 << 10;  // the most that the kernel puts together

  struct Slot {
    link::NetAddress from{};
    std::span<std::byte> bytes{};   // datagrams, one behind the other; empty: one without content
    std::size_t datagram_size = 0;  // of each but the last, which may be shorter
  };

  // Smaller slots are for tests.
  explicit Datagrams(std::size_t slot_bytes = kSlotBytes);
  Datagrams(const Datagrams&) = delete;
  Datagrams& operator=(const Datagrams&) = delete;
  ~Datagrams();

  // Of the last receive(), until the next one. The bytes may be written to (decryption in place).
  [[nodiscard]] std::span<const Slot> slots() const { return {slots_.get(), count_}; }

  // visit(const link::NetAddress& from, std::span<std::byte> datagram)
  template <typename Visit>
  void for_each_datagram(Visit&& visit) const;

 private:
  friend class UdpSocket;

  struct Calls;  // what recvmmsg() takes
  struct Outcome {
    std::size_t messages = 0;   // slots that were filled by the call
    std::size_t truncated = 0;  // of them: larger than a slot, or without sender; left out here
    std::optional<std::uint32_t> dropped_by_kernel{};  // since the socket was opened
  };
  Outcome receive(int socket);
  void prepare();
  void take(std::size_t index, Outcome& outcome);

  struct Release {
    void operator()(std::byte* pages) const;
  };
  std::size_t slot_bytes_;
  std::unique_ptr<std::byte, Release> pages_;
  std::unique_ptr<Calls> calls_;
  std::unique_ptr<Slot[]> slots_;
  std::size_t count_ = 0;
  std::size_t used_ = kSlots;  // by the last call
};

template <typename Visit>
void Datagrams::for_each_datagram(Visit&& visit) const {
  for (const Slot& slot : slots()) {
    std::span<std::byte> rest = slot.bytes;
    do {
      const std::size_t size = std::min(slot.datagram_size, rest.size());
      visit(slot.from, rest.first(size));
      rest = rest.subspan(size);
    } while (!rest.empty());
  }
}

struct UdpOptions {
  std::uint32_t buffer_bytes = 8U << 20;  // asked of the system, in each direction
  bool segmentation = true;               // false: as in a kernel without UDP_SEGMENT
  bool fragments = false;                 // what is too big for the way goes in IP fragments
};

enum class Sent : std::uint8_t {
  kAll,
  kWouldBlock,   // nothing of it went: again when the socket is writable
  kTooBig,       // larger than the interface takes: nothing of it went
  kUnreachable,  // no way there, or no memory at the moment: lost like a datagram on the wire
  kFailed,       // the system calls this burst wrong: never again
};

class UdpSocket final : public link::DatagramSender {
 public:
  struct Counters {
    std::uint64_t dropped_by_kernel = 0;  // no room in the receive buffer; known with the next one
    std::uint64_t truncated = 0;          // arrivals that were left out
    std::uint64_t cut_short = 0;  // datagrams at the end of bursts: the send buffer became full
  };

  // "[::]:2010" is for IPv4 as well. Port 0: the system chooses one.
  static Result<UdpSocket> open(const config::Endpoint& where, const UdpOptions& options = {});

  [[nodiscard]] int fd() const { return file_.get(); }
  [[nodiscard]] const link::NetAddress& local() const { return local_; }
  // When it was opened, no interface had this address yet.
  [[nodiscard]] bool is_early() const { return is_early_; }

  // As asked for; half of what the system accounts with, which charges for its own records too.
  [[nodiscard]] std::uint32_t receive_buffer_bytes() const { return receive_buffer_bytes_; }
  [[nodiscard]] std::uint32_t send_buffer_bytes() const { return send_buffer_bytes_; }
  [[nodiscard]] std::uint32_t asked_buffer_bytes() const { return options_.buffer_bytes; }

  Sent send(const link::Burst& burst);
  bool offer(const link::Burst& burst) override { return send(burst) != Sent::kWouldBlock; }

  // Puts what has come into `into`; false when nothing waits.
  bool receive(Datagrams& into);

  // Interfaces may have changed: whoever was refused bursts is tried again.
  void forget_refusals() { plain_.clear(); }

  [[nodiscard]] const Counters& counters() const { return counters_; }

 private:
  UdpSocket(os::File file, int family, const UdpOptions& options);

  void request_buffers();
  void set_options();
  bool bind(const link::NetAddress& where);

  Sent send_segmented(const link::Burst& burst);
  Sent send_plain(const link::Burst& burst);
  [[nodiscard]] bool is_plain(const link::NetAddress& to) const;
  void remember_plain(const link::NetAddress& to);

  os::File file_;
  int family_ = 0;
  UdpOptions options_;
  link::NetAddress local_{};
  bool is_early_ = false;
  std::uint32_t receive_buffer_bytes_ = 0;
  std::uint32_t send_buffer_bytes_ = 0;
  Counters counters_{};
  std::uint32_t kernel_drops_ = 0;       // as last reported
  std::vector<link::NetAddress> plain_;  // whose interface refuses UDP_SEGMENT
  std::size_t plain_next_ = 0;           // to be overwritten
};

}  // namespace tims::io

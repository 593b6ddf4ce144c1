// A UDP socket that sends bursts of datagrams in one call (UDP_SEGMENT), receives many in one
// call (recvmmsg, UDP_GRO), and does not fragment unless configured to. The owner waits for fd()
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
#include "os/socket_store.h"
#include "router/config/config.h"
#include "router/io/net/addresses.h"
#include "router/link/transport.h"
#include "tims/result.h"

namespace tims::io {

// Receive buffers: up to 16 slots in one call, each with many datagrams of one sender where the
// kernel combines them. The memory is allocated once.
class Datagrams {
 public:
  static constexpr std::size_t kSlots = 16;
  static constexpr std::size_t kSlotBytes = 64 << 10;  // the maximum the kernel combines

  struct Slot {
    link::NetAddress from{};
    std::span<std::byte> bytes{};   // concatenated datagrams; empty: one without content
    std::size_t datagram_size = 0;  // of all but the last, which may be shorter
  };

  // Smaller slots are for tests.
  explicit Datagrams(std::size_t slot_bytes = kSlotBytes);
  Datagrams(const Datagrams&) = delete;
  Datagrams& operator=(const Datagrams&) = delete;
  ~Datagrams();

  // Result of the last receive(), until the next one. The bytes may be modified (decryption in
  // place).
  [[nodiscard]] std::span<const Slot> slots() const { return {slots_.get(), count_}; }

  // Whether nothing had been left in the socket when the last receive() returned.
  [[nodiscard]] bool took_all() const { return used_ > 0 && used_ < kSlots; }

  // visit(const link::NetAddress& from, std::span<std::byte> datagram)
  template <typename Visit>
  void for_each_datagram(Visit&& visit) const;

 private:
  friend class UdpSocket;

  struct Calls;  // arguments of recvmmsg()
  struct Outcome {
    std::size_t messages = 0;   // slots that were filled by the call
    std::size_t truncated = 0;  // of them larger than a slot, or without sender; not returned
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
  std::uint32_t buffer_bytes = 8U << 20;  // requested from the system, in each direction
  bool segmentation = true;               // false: behave as on a kernel without UDP_SEGMENT
  // Allow IP fragmentation of datagrams larger than the path MTU.
  bool fragments = false;
};

enum class Sent : std::uint8_t {
  kAll,
  kWouldBlock,   // nothing was sent: retry when the socket is writable
  kTooBig,       // larger than the interface's MTU: nothing was sent
  kUnreachable,  // no route, or no memory at the moment: lost like a datagram on the wire
  kFailed,       // the system rejects this burst: do not retry
};

class UdpSocket final : public link::DatagramSender {
 public:
  struct Counters {
    std::uint64_t dropped_by_kernel = 0;  // receive buffer full; reported with the next datagram
    std::uint64_t truncated = 0;          // received datagrams that were discarded
    // Datagrams at the end of bursts, lost because the send buffer became full.
    std::uint64_t cut_short = 0;
  };

  // "[::]:2010" also accepts IPv4. Port 0: the system chooses one. `store`: what may have the
  // socket already, with datagrams that wait in it, and keeps it; nullptr: nothing.
  static Result<UdpSocket> open(const config::Endpoint& where, const UdpOptions& options = {},
                                os::SocketStore* store = nullptr);

  [[nodiscard]] int fd() const { return file_.get(); }
  [[nodiscard]] const link::NetAddress& local() const { return local_; }
  // False: no datagram of this socket can go there, because of its family, or because it is bound
  // to the loopback or to one IPv6 address.
  [[nodiscard]] bool can_reach(const link::NetAddress& to) const;
  // True when no interface had this address yet at opening.
  [[nodiscard]] bool is_early() const { return is_early_; }

  // The requested size; half of what the system accounts for, which includes its own records.
  [[nodiscard]] std::uint32_t receive_buffer_bytes() const { return receive_buffer_bytes_; }
  [[nodiscard]] std::uint32_t send_buffer_bytes() const { return send_buffer_bytes_; }
  [[nodiscard]] std::uint32_t asked_buffer_bytes() const { return options_.buffer_bytes; }

  Sent send(const link::Burst& burst);
  bool offer(const link::Burst& burst) override { return send(burst) != Sent::kWouldBlock; }

  // Stores received datagrams in `into`; returns false when there are none.
  bool receive(Datagrams& into);

  // Interfaces may have changed: try bursts again to addresses for which they were refused.
  void forget_refusals() { plain_.clear(); }

  [[nodiscard]] const Counters& counters() const { return counters_; }

 private:
  UdpSocket(os::File file, int family, const UdpOptions& options);

  void request_buffers();
  void set_options();
  bool bind(SystemAddress& address);
  bool read_local_address();

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
  std::vector<link::NetAddress> plain_;  // addresses whose interface refuses UDP_SEGMENT
  std::size_t plain_next_ = 0;           // next entry to overwrite
};

}  // namespace tims::io

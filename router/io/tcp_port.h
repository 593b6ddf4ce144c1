// TCP port: original RACK programs and remote clients.
//
// A turn reads once from one connection, at most 256 KiB, delivers every complete message to the
// router, and then writes once to each connection with output. A slow reader blocks no other
// client and never receives a partial message: while a socket accepts everything, messages go
// into it without a copy from where they were received, as many as possible per system call; the
// rest waits in a MessageQueue, whole messages by priority, until the socket is writable again
// (TcpOutput).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <sys/uio.h>

#include "base/slot_map.h"
#include "os/file.h"
#include "router/config/config.h"
#include "router/core/message_queue.h"
#include "router/core/queue_shares.h"
#include "router/core/router.h"
#include "router/core/statistics.h"
#include "router/core/stream_counters.h"
#include "router/core/types.h"
#include "router/io/acceptor.h"
#include "router/io/log.h"
#include "router/io/loop.h"
#include "router/io/rights.h"
#include "router/io/waiting_memory.h"
#include "wire/tcp_protocol.h"

namespace tims::io {

// The output of one TCP connection.
class TcpOutput final : private core::QueueOwner {
 public:
  // `on_loss`: called when waiting messages were dropped for other clients, or the connection was
  // given up for them.
  TcpOutput(int socket, core::QueueShares& shares, std::uint64_t queue_bytes_max,
            const core::PriorityClasses& classes = core::kConventionalClasses,
            std::function<void()> on_loss = nullptr)
      : socket_(socket),
        classes_(classes),
        queue_(shares, *this, queue_bytes_max, classes),
        on_loss_(std::move(on_loss)) {}
  TcpOutput(const TcpOutput&) = delete;
  TcpOutput& operator=(const TcpOutput&) = delete;

  void set_queue_bytes_max(std::uint64_t bytes) { queue_.set_bytes_max(bytes); }
  // From now on, only the newest sample of each stream waits.
  void keep_newest();
  // Null: keep_newest() was not called.
  [[nodiscard]] const core::StreamCounters* streams() const { return streams_.get(); }

  // Adds a whole message. The bytes must stay valid until write_batch(), unless the queue has
  // copied them. `priority` applies if it must wait.
  core::Outcome add(std::span<const std::byte> message, std::uint8_t priority);

  // Writes the messages added since the last call; their bytes are not needed afterwards.
  void write_batch();
  // The socket is writable again: writes a bounded amount from the queue. Returns the number of
  // bytes.
  std::size_t write_queue();

  enum class State : std::uint8_t {
    kIdle,         // everything is written
    kWaiting,      // for the socket to become writable
    kBroken,       // the connection is gone
    kOutOfMemory,  // a message was written partly, and the memory for its rest was given to others
  };
  [[nodiscard]] State state() const;
  [[nodiscard]] std::uint64_t queued_bytes() const { return queue_.bytes(); }

  // Messages that were accepted and then lost, by reason; reported once.
  struct Lost {
    core::LossCounts replaced{};
    core::LossCounts refused{};
    core::LossCounts gone{};
  };
  // Null when there are none.
  [[nodiscard]] const Lost* lost() const { return may_have_lost_ ? &lost_ : nullptr; }
  void forget_lost();
  // Counts everything not yet written as lost.
  void abandon();

 private:
  static constexpr std::size_t kPiecesMax = 64;

  // core::QueueOwner
  void on_dropped(const core::LossCounts& lost) override;
  void give_up() override;

  std::size_t send(std::span<const iovec> pieces);
  void write_singly();
  void keep_rest(std::size_t written);
  void keep(std::span<const std::byte> message, const Header& header, std::size_t written);
  template <typename Visit>
  void for_each_message(Visit visit) const;

  int socket_;
  const core::PriorityClasses& classes_;
  State failure_ = State::kIdle;
  std::size_t piece_count_ = 0;
  std::size_t batch_bytes_ = 0;
  // whole messages, concatenated in each piece
  std::array<iovec, kPiecesMax> pieces_{};
  std::unique_ptr<core::StreamCounters> streams_;
  core::MessageQueue queue_;
  Lost lost_;
  bool may_have_lost_ = false;
  std::function<void()> on_loss_;
};

// One client of the TCP port.
struct TcpConnection {
  TcpConnection(os::File socket, std::uint32_t message_max, core::QueueShares& shares,
                std::uint64_t queue_bytes_max, const core::PriorityClasses& classes,
                std::function<void(TcpConnection&)> on_loss);

  // Reads the available data, at most `scratch` and the rest of a large message. Bytes not yet in
  // the reader are returned as part of `scratch`.
  enum class ReadStatus : std::uint8_t { kSome, kNothing, kClosed, kLost };
  struct Read {
    ReadStatus status;
    std::span<std::byte> chunk;
  };
  Read read(std::span<std::byte> scratch);

  os::File socket;
  std::optional<Watch> watch;
  wire::StreamReader reader;
  TcpOutput output;
  std::optional<Person> person{};  // who has proven to be here; empty: had not to
  core::ClientId id{};
  std::uint32_t token = 0;
  bool touched = false;  // to be processed at the next flush
  bool closing = false;  // unknown to the router; removed at the next flush
};

struct TcpPortSettings {
  std::uint32_t message_max = kMessageMaxDefault;
  std::uint64_t queue_bytes_max = 4U << 20;  // for one connection; at least one message
};

class TcpPort final : public core::Port {
 public:
  TcpPort(Loop& loop, core::Router& router, Log& log, core::QueueShares& shares,
          const TcpPortSettings& settings);

  // Returns the listening address.
  Result<config::Endpoint> listen(const config::Endpoint& where, os::SocketStore* store = nullptr) {
    return acceptor_.listen(where, store);
  }
  void set_queue_bytes_max(std::uint64_t bytes);
  // From now on, connections come by the gate; `who` is called for those with a certificate.
  using Who = std::function<std::optional<Person>(const security::Certificate&)>;
  void guard_by(TlsGate& gate, TlsGate::Entrance entrance, Who who);
  // Null: it had not to prove who it is.
  [[nodiscard]] const Person* person(std::uint32_t token) const;

  // core::Port
  core::Outcome deliver(Time now, const core::Receiver& to, const core::Message& message) override;
  void reply(Time now, const core::Receiver& to, const Header& header) override;
  void close(const core::Receiver& client, core::CloseReason reason) override;
  void keep_newest(const core::Receiver& client) override;
  [[nodiscard]] const core::StreamCounters* streams(std::uint32_t token) const override;
  void flush(Time now) override;
  [[nodiscard]] std::uint64_t queued_bytes(std::uint32_t token) const override;
  void stop_accepting() override { acceptor_.stop(); }
  [[nodiscard]] bool drained() const override;

 private:
  static constexpr std::size_t kScratchBytes = 256 << 10;
  // The kernel copies several times faster to the start of a page than to 16 bytes after it.
  struct alignas(4096) Scratch {
    std::byte bytes[kScratchBytes];
  };

  void welcome(os::File socket, const Visitor& visitor);
  bool may_send(Time now, TcpConnection& connection, const core::Message& message);
  void make_room(Time now);

  void on_ready(TcpConnection& connection, Ready ready);
  void read_some(Time now, TcpConnection& connection);
  void take_messages(Time now, TcpConnection& connection, std::span<std::byte> chunk);
  void take_message(Time now, TcpConnection& connection, const wire::StreamReader::Item& item);
  void bound_half_messages(Time now, std::uint32_t token, core::ClientId id);
  void refuse_length(Time now, TcpConnection& connection, const wire::StreamReader::Item& item);
  void on_end_of_input(Time now, TcpConnection& connection, core::CloseReason reason);

  void write_more(TcpConnection& connection);
  void settle(Time now, TcpConnection& connection);
  void report_losses(Time now, TcpConnection& connection);
  void forget(Time now, TcpConnection& connection, core::CloseReason reason);
  void erase(Time now, TcpConnection& connection);

  TcpConnection* find(std::uint32_t token, core::ClientId id);
  void touch(TcpConnection& connection);
  std::span<std::byte> keep(std::span<const std::byte> bytes);

  Loop& loop_;
  core::Router& router_;
  core::QueueShares& shares_;
  TcpPortSettings settings_;
  Acceptor acceptor_;
  Who who_{};
  base::SlotMap<TcpConnection> connections_;  // by token
  std::vector<TcpConnection*> touched_;
  HalfMessages half_messages_;
  std::unique_ptr<Scratch> scratch_;  // data read in this turn
  // Replies of the router, and small messages whose bytes do not stay valid, until the flush.
  std::unique_ptr<std::byte[]> kept_;
  std::size_t kept_size_ = 0;
};

}  // namespace tims::io

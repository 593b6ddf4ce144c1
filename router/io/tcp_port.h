// TCP port: original RACK programs and remote clients.
//
// A turn reads once from one connection, at most 256 KiB, hands every whole message to the router,
// and then writes once to each connection that got something. A slow reader blocks nobody and never
// sees a torn message: as long as a socket takes everything, messages go from where they were
// received into it without a copy, as many as possible with one system call; what it does not take
// waits in a MessageQueue, whole messages in order of importance, until the socket is writable
// again (TcpOutput).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <sys/uio.h>

#include "base/slot_map.h"
#include "os/file.h"
#include "router/config/config.h"
#include "router/core/byte_chain.h"
#include "router/core/message_queue.h"
#include "router/core/router.h"
#include "router/core/statistics.h"
#include "router/core/types.h"
#include "router/io/acceptor.h"
#include "router/io/log.h"
#include "router/io/loop.h"
#include "router/io/waiting_memory.h"
#include "wire/tcp_protocol.h"

namespace tims::io {

// What is to be written into one TCP connection.
class TcpOutput {
 public:
  TcpOutput(int socket, core::BlockPool& pool, std::uint64_t queue_bytes_max,
            const core::PriorityClasses& classes = core::kConventionalClasses)
      : socket_(socket),
        classes_(classes),
        queue_(pool, queue_bytes_max, core::MessageQueue::Share::kFair, classes) {}

  void set_queue_bytes_max(std::uint64_t bytes) { queue_.set_bytes_max(bytes); }

  // A whole message. The bytes must stay until write_batch(), unless the queue has taken them.
  // `priority` is the one it waits with, if it must.
  core::Outcome add(std::span<const std::byte> message, std::uint8_t priority);

  // Writes what was added since the last time; after it the bytes are not needed any more.
  void write_batch();
  // The socket is writable again: writes from the queue, a bounded amount. Returns how much.
  std::size_t write_queue();

  enum class State : std::uint8_t {
    kIdle,         // everything is written
    kWaiting,      // for the socket to become writable
    kBroken,       // the connection is gone
    kOutOfMemory,  // a message could be written only in part, and there is no room for its rest
  };
  [[nodiscard]] State state() const;
  [[nodiscard]] std::uint64_t queued_bytes() const { return queue_.bytes(); }

  // Messages that were taken and then lost, by reason; told once.
  struct Lost {
    core::LossCounts replaced{};
    core::LossCounts refused{};
    core::LossCounts gone{};
  };
  // Null when there certainly are none.
  [[nodiscard]] const Lost* lost() const { return may_have_lost_ ? &lost_ : nullptr; }
  void forget_lost();
  // Counts everything not yet written as gone.
  void abandon();

 private:
  static constexpr std::size_t kPiecesMax = 64;

  std::size_t send(std::span<const iovec> pieces);
  void keep_rest(std::size_t written);
  void keep(std::span<const std::byte> message, const Header& header, std::size_t written);
  template <typename Visit>
  void for_each_message(Visit visit) const;

  int socket_;
  const core::PriorityClasses& classes_;
  State failure_ = State::kIdle;
  std::size_t piece_count_ = 0;
  std::size_t batch_bytes_ = 0;
  // Whole messages, one behind the other in each piece.
  std::array<iovec, kPiecesMax> pieces_{};
  core::MessageQueue queue_;
  Lost lost_;
  bool may_have_lost_ = false;
};

// One client of the TCP port.
struct TcpConnection {
  TcpConnection(os::File socket, std::uint32_t message_max, core::BlockPool& pool,
                std::uint64_t queue_bytes_max, const core::PriorityClasses& classes);

  // Reads what is there, at most `scratch` and the rest of a large message. The bytes that are not
  // yet in the reader come back as a part of `scratch`.
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
  core::ClientId id{};
  std::uint32_t token = 0;
  bool touched = false;  // the port must look at it when it flushes
  bool closing = false;  // the router knows it no more; goes with the next flush
};

struct TcpPortSettings {
  std::uint32_t message_max = kMessageMaxDefault;
  std::uint64_t queue_bytes_max = 4U << 20;  // for one connection; at least one message
};

class TcpPort final : public core::Port {
 public:
  TcpPort(Loop& loop, core::Router& router, Log& log, core::BlockPool& pool,
          const TcpPortSettings& settings);

  // Where it listens.
  Result<config::Endpoint> listen(const config::Endpoint& where) { return acceptor_.listen(where); }
  void set_queue_bytes_max(std::uint64_t bytes);

  // core::Port
  core::Outcome deliver(Time now, const core::Receiver& to, const core::Message& message) override;
  void reply(Time now, const core::Receiver& to, const Header& header) override;
  void close(const core::Receiver& client, core::CloseReason reason) override;
  void flush(Time now) override;
  [[nodiscard]] std::uint64_t queued_bytes(std::uint32_t token) const override;
  void stop_accepting() override { acceptor_.stop(); }
  [[nodiscard]] bool drained() const override;

 private:
  static constexpr std::size_t kScratchBytes = 256 << 10;
  // The kernel copies into the start of a page several times as fast as to 16 bytes behind it.
  struct alignas(4096) Scratch {
    std::byte bytes[kScratchBytes];
  };

  void welcome(os::File socket, const std::string& peer);
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
  core::BlockPool& pool_;
  TcpPortSettings settings_;
  Acceptor acceptor_;
  base::SlotMap<TcpConnection> connections_;  // by token
  std::vector<TcpConnection*> touched_;
  HalfMessages half_messages_;
  std::unique_ptr<Scratch> scratch_;  // what was read this turn
  // Replies of the router, and small messages whose bytes do not stay, until the flush.
  std::unique_ptr<std::byte[]> kept_;
  std::size_t kept_size_ = 0;
};

}  // namespace tims::io

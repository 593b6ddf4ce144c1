// TCP port: original RACK programs and remote clients.
//
// A turn reads once from one connection, at most 256 KiB, hands every whole message to the router,
// and then writes once to each connection that got something. A slow reader blocks nobody and never
// sees a torn message (tcp_output.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "router/config/config.h"
#include "router/core/byte_chain.h"
#include "router/core/router.h"
#include "router/io/acceptor.h"
#include "router/io/half_messages.h"
#include "router/io/log.h"
#include "router/io/port.h"
#include "router/io/tcp_connection.h"

namespace tims::io {

struct TcpPortSettings {
  std::uint32_t message_max = kMessageMaxDefault;
  std::uint64_t queue_bytes_max = 4U << 20;  // for one connection; at least one message
};

class TcpPort final : public Port {
 public:
  // `end_turn` flushes all ports: called when a turn is over.
  TcpPort(Loop& loop, core::Router& router, Log& log, core::BlockPool& pool,
          std::function<void(Time)> end_turn, const TcpPortSettings& settings);

  // Where it listens.
  Result<config::Endpoint> listen(const config::Endpoint& where) { return acceptor_.listen(where); }
  void set_queue_bytes_max(std::uint64_t bytes);

  // Port
  core::Outcome deliver(const core::Receiver& to, const core::Message& message) override;
  void reply(const core::Receiver& to, const Header& header) override;
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
  std::uint32_t free_token();

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
  const std::function<void(Time)> end_turn_;
  TcpPortSettings settings_;
  Acceptor acceptor_;
  std::vector<std::unique_ptr<TcpConnection>> connections_;  // by token
  std::vector<std::uint32_t> free_tokens_;
  std::vector<TcpConnection*> touched_;
  HalfMessages half_messages_;
  std::unique_ptr<Scratch> scratch_;  // what was read this turn
  // Replies of the router, and small messages whose bytes do not stay, until the flush.
  std::unique_ptr<std::byte[]> kept_;
  std::size_t kept_size_ = 0;
};

}  // namespace tims::io

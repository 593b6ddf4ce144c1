// The path of links over TCP, for networks that let no UDP through: the same datagrams, each with
// its size before it (router/link/datagram_stream.h), on one connection to the upper router.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "os/file.h"
#include "router/io/acceptor.h"
#include "router/io/log.h"
#include "router/io/loop.h"
#include "router/link/datagram_stream.h"
#include "router/link/transport.h"

namespace tims::io {

class TcpPath final : public link::DatagramSender {
 public:
  // Waiting for one that does not read; datagrams beyond it are lost, as on a slow network.
  static constexpr std::size_t kQueueBytesMax = 256 << 10;
  // Connections from which no link has come yet; beyond it, the oldest ends.
  static constexpr std::size_t kStrangersMax = 64;
  static constexpr Duration kStrangerTime = std::chrono::seconds(10);
  static constexpr Duration kConnectTime = std::chrono::seconds(3);
  static constexpr Duration kCallAgain = std::chrono::seconds(1);  // after a failed one

  class Listener : public core::Interface {
   public:
    // The bytes stay valid until flush().
    virtual void on_tcp_datagram(const link::NetAddress& from, std::span<std::byte> datagram) = 0;
    // Its connection has ended.
    virtual void on_tcp_gone(const link::NetAddress& address) = 0;
    virtual void on_tcp_turn_end() = 0;
    // Whether a link is meant for the router at this address: it is called.
    [[nodiscard]] virtual bool is_called(const link::NetAddress& address) const = 0;
    // Whether a link has found its router there.
    [[nodiscard]] virtual bool is_linked(const link::NetAddress& address) const = 0;
  };

  TcpPath(Loop& loop, Log& log, Listener& listener);
  TcpPath(const TcpPath&) = delete;
  TcpPath& operator=(const TcpPath&) = delete;
  ~TcpPath() override;

  // For routers that connect. Returns the listening address.
  // `store`: what may have the socket already, and keeps it; nullptr: nothing.
  Result<config::Endpoint> listen(const config::Endpoint& where, os::SocketStore* store = nullptr);
  [[nodiscard]] bool listens() const { return is_listening_; }

  // Connects to a called router if there is no connection yet. Never refuses: what has no room, and
  // what is for an address without connection, is lost.
  bool offer(const link::Burst& burst) override;
  // Writes what was offered. Call it at the end of each turn, when nobody needs what has arrived in
  // it any more.
  void flush();

  [[nodiscard]] Time next_timeout() const;
  void on_timeout(Time now);

  [[nodiscard]] std::size_t connections() const { return connections_.size(); }
  [[nodiscard]] std::uint64_t lost() const { return lost_; }  // datagrams without room

 private:
  struct Connection {
    os::File socket;
    std::unique_ptr<Watch> watch{};
    bool is_ours = false;  // this side has connected, or still does:
    bool is_connecting = false;
    bool is_linked = false;  // seen in use by a link
    Time since{};
    link::DatagramStream arriving{};
    std::vector<std::byte> queue{};  // with sizes
    std::size_t sent = 0;            // of the queue
  };
  // Of a called router.
  struct Call {
    Time next{};
    std::string failure{};  // the last one that was logged
  };
  using Connections = std::map<link::NetAddress, Connection>;

  void accept(os::File socket);
  void make_room_for_a_stranger();
  Connections::iterator call(Time now, const link::NetAddress& to);
  void add(const link::NetAddress& address, Connection connection);
  void put(Connection& connection, std::span<const std::byte> datagram);
  void on_ready(const link::NetAddress& address, Ready ready);
  std::string receive(const link::NetAddress& address, Connection& connection);
  static void write(Connection& connection);
  void end(Connections::iterator connection, const std::string& why);
  [[nodiscard]] bool is_overdue(Time now, const link::NetAddress& address, Connection& connection,
                                std::string& why) const;

  Loop& loop_;
  Log& log_;
  Listener& listener_;
  Acceptor acceptor_;
  bool is_listening_ = false;
  Connections connections_;
  std::map<link::NetAddress, Call> calls_;
  std::vector<link::NetAddress> offered_;    // connections with something to write
  std::vector<std::byte> room_;              // for what is read
  std::vector<link::DatagramStream> ended_;  // of connections that have ended in this turn
  std::uint64_t lost_ = 0;
  Time next_look_ = kNever;
};

}  // namespace tims::io

// The shell of the links (router/link/links.h), which are the router's port for other routers:
// the UDP socket and DDS below them, name resolution of other hosts, changes of this host's
// network, and fault injection.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <queue>
#include <string>
#include <vector>

#include "router/config/config.h"
#include "router/io/admin_source.h"
#include "router/io/crypto/tls_handshaker.h"
#include "router/io/dds/dds_process.h"
#include "router/io/list_keeper.h"
#include "router/io/log.h"
#include "router/io/loop.h"
#include "router/io/net/addresses.h"
#include "router/io/net/resolver.h"
#include "router/io/net/udp_socket.h"
#include "router/io/tcp_path.h"
#include "router/io/waiting_memory.h"
#include "router/link/fault_injection.h"
#include "router/link/handover.h"
#include "router/link/links.h"

namespace tims::io {

// The DDS path below the links: passes datagrams received by the engine to the links, and
// datagrams sent by the links to the engine.
class DdsPath final : public link::DatagramSender, private DdsEngine::Listener {
 public:
  DdsPath(Loop& loop, Log& log, link::Links& links, const config::Config& config);

  // `udp`: the addresses at which this router receives datagrams.
  Result<void> start(std::vector<link::NetAddress> udp);
  // The addresses of this host may have changed.
  void network_changed(std::vector<link::NetAddress> udp);
  void stop() { engine_.stop(); }

  // A burst that the engine does not accept is lost, as it could be on the network.
  bool offer(const link::Burst& burst) override {
    (void)engine_.send(burst);
    return true;
  }

  [[nodiscard]] const DdsProcess& engine() const { return engine_; }

 private:
  // DdsEngine::Listener
  void on_datagram(const link::NetAddress& from, std::span<std::byte> datagram) override;
  void on_announced(const link::Announcement& announcement) override;
  void on_gone(const link::NetAddress& dds) override;
  void on_state() override;
  void on_turn_end() override;
  // The participant announces other addresses than this host has now, or will when it is up.
  [[nodiscard]] bool is_outdated() const;

  Loop& loop_;
  Log& log_;
  link::Links& links_;
  link::Announcement self_;
  DdsProcess engine_;
};

class LinkPort final : private link::LinksShell,
                       private link::DatagramSender,
                       private TcpPath::Listener {
 public:
  // A newer list of the fleet has come over a link; it is good.
  using OnList = std::function<void(Time now, CheckedList&& list)>;
  // `keys`: the folder of keys; empty: this router has none.
  LinkPort(Loop& loop, core::Router& router, Log& log, core::BlockPool& pool,
           const link::LinksSetup& setup, const std::string& keys, OnList on_list);

  // Opens the socket; returns the listening address.
  Result<std::string> listen(const config::Endpoint& where, os::SocketStore& store);
  // Announces this router in the fleet and enables the DDS path.
  Result<void> join(const config::Config& config);
  // Prepares the path over TCP for links that have it. Returns the listening address, which is that
  // of UDP; empty: no router connects by it, or it was open before.
  Result<std::string> open_tcp(const config::Config& config, os::SocketStore& store);
  [[nodiscard]] bool is_open() const { return socket_ || dds_ || tcp_; }
  // Applies the links of the configuration; also after a reload.
  void configure(Time now, const config::Config& config);

  // The keys of this router, when it starts and whenever they have changed. With other
  // certificates, new handshakes prove both sides again; with another list, links with routers that
  // it revokes, or whose root is believed no longer, end, and the others are told. Precondition:
  // there is a folder of keys.
  Result<void> use_keys(Time now, const security::Credentials& credentials,
                        const security::Strictness& strictness);

  // To be attached to the router.
  [[nodiscard]] core::Port& port() { return links_; }
  // Call after all ports were flushed.
  void release();
  // Notifies the other routers that this one exits.
  void end(Time now);
  // The others are asked to wait for the next router.
  void announce_pause(Time now) { links_.announce_pause(now); }
  void stop();

  // As Links::restore(). Meanwhile datagrams wait in the socket.
  std::size_t restore(Time now, link::Handover former);

  [[nodiscard]] Time next_timeout() const;
  void on_timeout(Time now);

  // Returns false when no link has this name. Acts in a turn of its own: the answer to who asked
  // may go over this link, and must be sent before.
  bool act(std::string_view name, link::Links::Action what);
  // Sets the faults of all outgoing datagrams, replacing earlier ones; with a name, only those of
  // one link. Returns false when no link has this name.
  bool inject_faults(std::string_view name, const link::Faults& faults);
  // The faults of what is sent over the link by UDP; null: none.
  [[nodiscard]] const link::Faults* faults_of(const link::Link& link) const;

  [[nodiscard]] const link::Links& links() const { return links_; }
  [[nodiscard]] bool is_in_fleet() const { return dds_.has_value(); }
  // Empty before listen() and join().
  [[nodiscard]] std::optional<UdpReport> udp_report() const;
  [[nodiscard]] std::optional<DdsReport> dds_report() const;

 private:
  struct Delayed {  // in transit through the simulated bad network
    Time at{};
    std::uint64_t order = 0;
    link::NetAddress to{};
    std::vector<std::byte> bytes{};
    bool operator>(const Delayed& other) const {
      return at != other.at ? at > other.at : order > other.order;
    }
  };

  [[nodiscard]] std::unique_ptr<TlsHandshaker> make_handshaker();
  [[nodiscard]] std::unique_ptr<ListKeeper> make_list_keeper(const std::string& keys);
  [[nodiscard]] link::LinksSetup with_keys(link::LinksSetup setup) const;
  void on_list_checked(CheckedList&& list);
  [[nodiscard]] Result<void> check_memory() const;
  void on_ready(Ready ready);
  void take_datagrams(Time now);
  // link::LinksShell
  void wait_for_sender() override;
  void continue_later() override;
  void receive_again() override;
  // link::DatagramSender, in place of the socket while faults are injected
  bool offer(const link::Burst& burst) override;
  // TcpPath::Listener
  void on_tcp_datagram(const link::NetAddress& from, std::span<std::byte> datagram) override;
  void on_tcp_gone(const link::NetAddress& address) override;
  void on_tcp_turn_end() override;
  [[nodiscard]] bool is_called(const link::NetAddress& address) const override;
  [[nodiscard]] bool is_linked(const link::NetAddress& address) const override;
  void choose_sender();
  void clear_faults();
  void resolve(Time now);
  void resolve_one(const std::string& to);
  [[nodiscard]] Resolver::Addresses reachable(const Resolver::Addresses& addresses) const;
  void note_unreachable(const std::string& to, const Resolver::Addresses& addresses);
  void watch_network();
  void on_network_change();
  [[nodiscard]] std::vector<link::NetAddress> udp_addresses() const;
  void read_wall_clock(Time now);

  Loop& loop_;
  Log& log_;
  OnList on_list_;
  std::unique_ptr<TlsHandshaker> handshaker_;  // null: no keys
  std::unique_ptr<ListKeeper> list_keeper_;    // likewise
  std::vector<security::Certificate> shown_;   // own chain and believed roots
  WaitingMemory parts_;                        // messages received in parts
  link::MessageMemory memory_;
  link::Links links_;
  std::optional<UdpSocket> socket_;
  std::optional<Watch> watch_;
  std::optional<DdsPath> dds_;
  std::optional<TcpPath> tcp_;
  Datagrams datagrams_;
  bool continues_ = false;

  Resolver resolver_;
  InterfaceWatch interfaces_;
  bool watches_network_ = false;
  std::map<std::string, std::pair<std::string, std::uint16_t>> names_;  // `to`: host and port
  std::map<std::string, std::size_t> tries_;  // index of the next address of a name to try
  Time next_resolve_ = kNever;
  Time wall_read_{};

  struct Injected {
    std::string link{};  // as given in the request
    link::FaultInjector faults;
  };
  std::map<link::NetAddress, Injected> injected_;  // by destination of the datagrams
  std::optional<link::FaultInjector> injected_everywhere_;
  std::priority_queue<Delayed, std::vector<Delayed>, std::greater<>> delayed_;
  std::uint64_t order_ = 0;
};

}  // namespace tims::io

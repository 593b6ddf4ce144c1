// The shell of the links (router/link/links.h), which are the router's port for other routers: the
// UDP socket and DDS under them, the names of other hosts, what changes about this host's network,
// and a bad network on purpose.
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
#include "router/io/dds/dds_engine.h"
#include "router/io/log.h"
#include "router/io/loop.h"
#include "router/io/net/addresses.h"
#include "router/io/net/resolver.h"
#include "router/io/net/udp_socket.h"
#include "router/io/reports.h"
#include "router/io/waiting_memory.h"
#include "router/link/fault_injection.h"
#include "router/link/links.h"

namespace tims::io {

// The DDS path under the links: what the engine brings goes to the links, and what they send by DDS
// goes to the engine.
class DdsPath final : public link::DatagramSender, private DdsEngine::Listener {
 public:
  DdsPath(Loop& loop, Log& log, link::Links& links, const config::Config& config);

  // `udp`: where this router takes datagrams.
  Result<void> start(std::vector<link::NetAddress> udp);
  // This host may have other addresses now.
  void network_changed(std::vector<link::NetAddress> udp);
  void stop() { engine_.stop(); }

  // One that the engine does not take is lost, as it might be on its way.
  bool offer(const link::Burst& burst) override {
    (void)engine_.send(burst);
    return true;
  }

  [[nodiscard]] const DdsEngine& engine() const { return engine_; }

 private:
  // DdsEngine::Listener
  void on_datagram(const link::NetAddress& from, std::span<std::byte> datagram) override;
  void on_announced(const link::Announcement& announcement) override;
  void on_gone(const link::NetAddress& dds) override;
  void on_state() override;
  void on_turn_end() override;

  Loop& loop_;
  Log& log_;
  link::Links& links_;
  link::Announcement self_;
  std::vector<link::NetAddress> host_;  // all addresses when the engine looked at its interfaces
  DdsEngine engine_;
};

class LinkPort final : private link::LinksShell, private link::DatagramSender {
 public:
  LinkPort(Loop& loop, core::Router& router, Log& log, core::BlockPool& pool,
           const link::LinksSetup& setup);

  // Opens the socket; where it listens.
  Result<std::string> listen(const config::Endpoint& where);
  // Becomes known in the fleet, and has the DDS path from here on.
  Result<void> join(const config::Config& config);
  [[nodiscard]] bool is_open() const { return socket_ || dds_; }
  // The links of the configuration; also those of a changed one.
  void configure(Time now, const config::Config& config);

  // To be attached to the router.
  [[nodiscard]] core::Port& port() { return links_; }
  // After all ports were flushed.
  void release();
  // Other routers hear that this one ends.
  void end(Time now);
  void stop();

  [[nodiscard]] Time next_timeout() const;
  void on_timeout(Time now);

  // False when no link has this name.
  bool act(Time now, std::string_view name, link::Links::Action what) {
    return links_.act(now, name, what);
  }
  // What happens to all datagrams on their way out, and nothing else any more; with a name, to
  // those of one link. False when no link has this name.
  bool inject_faults(std::string_view name, const link::Faults& faults);

  [[nodiscard]] const link::Links& links() const { return links_; }
  [[nodiscard]] bool is_in_fleet() const { return dds_.has_value(); }
  // Nothing before listen() and join().
  [[nodiscard]] std::optional<UdpReport> udp_report() const;
  [[nodiscard]] std::optional<DdsReport> dds_report() const;

 private:
  struct Delayed {  // on its way through a bad network
    Time at{};
    std::uint64_t order = 0;
    link::NetAddress to{};
    std::vector<std::byte> bytes{};
    bool operator>(const Delayed& other) const {
      return at != other.at ? at > other.at : order > other.order;
    }
  };

  [[nodiscard]] Result<void> check_memory() const;
  void on_ready(Ready ready);
  void take_datagrams(Time now);
  // link::LinksShell
  void wait_for_sender() override;
  void continue_later() override;
  // link::DatagramSender, in place of the socket while faults are injected
  bool offer(const link::Burst& burst) override;
  void choose_sender();
  void clear_faults();
  void resolve(Time now);
  void resolve_one(const std::string& to);
  void watch_network();
  void on_network_change();
  [[nodiscard]] std::vector<link::NetAddress> udp_addresses() const;
  void read_wall_clock(Time now);

  Loop& loop_;
  Log& log_;
  WaitingMemory parts_;  // messages that come in parts
  link::MessageMemory memory_;
  link::Links links_;
  std::optional<UdpSocket> socket_;
  std::optional<Watch> watch_;
  std::optional<DdsPath> dds_;
  Datagrams datagrams_;
  bool continues_ = false;

  Resolver resolver_;
  InterfaceWatch interfaces_;
  bool watches_network_ = false;
  std::map<std::string, std::pair<std::string, std::uint16_t>> names_;  // `to`: host and port
  std::map<std::string, std::size_t> tries_;  // which of a name's addresses is next
  Time next_resolve_ = kNever;
  Time wall_read_{};

  struct Injected {
    std::string link{};  // as it was named
    link::FaultInjector faults;
  };
  std::map<link::NetAddress, Injected> injected_;  // by where datagrams go
  std::optional<link::FaultInjector> injected_everywhere_;
  std::priority_queue<Delayed, std::vector<Delayed>, std::greater<>> delayed_;
  std::uint64_t order_ = 0;
};

}  // namespace tims::io

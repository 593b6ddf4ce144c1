// Where other routers attach: the UDP socket under the links (router/link), the names of other
// hosts, and what changes about this host's network.
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
#include "router/io/dds_path.h"
#include "router/io/log.h"
#include "router/io/net/interfaces.h"
#include "router/io/net/resolver.h"
#include "router/io/net/udp_socket.h"
#include "router/io/port.h"
#include "router/io/waiting_memory.h"
#include "router/io/watch.h"
#include "router/link/impairment.h"
#include "router/link/links.h"

namespace tims::io {

class LinkPort final : public Port {
 public:
  // `end_turn` flushes all ports: called when a turn is over.
  LinkPort(Loop& loop, core::Router& router, Log& log, core::BlockPool& pool,
           std::function<void(Time)> end_turn, const link::LinksSetup& setup);

  // Opens the socket; where it listens.
  Result<std::string> listen(const config::Endpoint& where);
  // Becomes known in the fleet, and has the DDS path from here on.
  Result<void> join(const config::Config& config);
  [[nodiscard]] bool is_open() const { return socket_ || dds_; }
  // The links of the configuration; also those of a changed one.
  void configure(Time now, const config::Config& config);

  // Port
  core::Outcome deliver(const core::Receiver& to, const core::Message& message) override {
    return links_.deliver(turn_time(), to.token, message);
  }
  void reply(const core::Receiver& to, const Header& header) override {
    links_.reply(turn_time(), to.token, header);
  }
  void close(const core::Receiver&, core::CloseReason) override {}  // links are not watched
  void flush(Time now) override;
  [[nodiscard]] std::uint64_t queued_bytes(std::uint32_t token) const override;
  void stop_accepting() override {}
  [[nodiscard]] bool drained() const override { return true; }

  // After all ports were flushed.
  void release();
  // Other routers hear that this one ends.
  void end(Time now);
  void stop();

  [[nodiscard]] Time next_timeout() const;
  void on_timeout(Time now);

  // By hand: false when no link has this name.
  bool by_hand(Time now, std::string_view name, link::Links::Hand what) {
    return links_.by_hand(now, name, what);
  }
  // What happens to all datagrams on their way out, and nothing else any more; with a name, to
  // those of one link. False when no link has this name.
  bool spoil(std::string_view name, const link::Faults& faults);

  [[nodiscard]] const link::Links& links() const { return links_; }
  [[nodiscard]] const UdpSocket* socket() const { return socket_ ? &*socket_ : nullptr; }
  [[nodiscard]] const DdsEngine* dds() const { return dds_ ? &dds_->engine() : nullptr; }

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
  // Read once a turn, when it is asked for first: the turn may be another port's.
  Time turn_time();
  void on_ready(Ready ready);
  void take_datagrams(Time now);
  void wait_for_writable(bool waits);
  void continue_later();
  bool send(Time now, const link::Train& train);
  void heal();
  bool send_spoiled(Time now, const link::Train& train, link::Impairment& impairment);
  void resolve(Time now);
  void resolve_one(const std::string& to);
  void watch_network();
  void on_network_change();
  [[nodiscard]] std::vector<link::NetAddress> udp_addresses() const;
  void read_wall_clock(Time now);

  Loop& loop_;
  Log& log_;
  const std::function<void(Time)> end_turn_;
  WaitingMemory parts_;  // messages that come in parts
  link::MessageMemory memory_;
  link::Links links_;
  std::optional<UdpSocket> socket_;
  std::optional<Watch> watch_;
  std::optional<DdsPath> dds_;
  Datagrams datagrams_;
  bool waits_for_writable_ = false;
  bool continues_ = false;

  Resolver resolver_;
  InterfaceWatch interfaces_;
  bool watches_network_ = false;
  std::map<std::string, std::pair<std::string, std::uint16_t>> names_;  // `to`: host and port
  std::map<std::string, std::size_t> tries_;  // which of a name's addresses is next
  Time next_resolve_ = kNever;
  Time wall_read_{};
  Time turn_{};

  struct Spoiled {
    std::string link{};  // as it was named
    link::Impairment impairment;
  };
  std::map<link::NetAddress, Spoiled> spoiled_;  // by where datagrams go
  std::optional<link::Impairment> all_impaired_;
  std::priority_queue<Delayed, std::vector<Delayed>, std::greater<>> delayed_;
  std::uint64_t order_ = 0;
};

}  // namespace tims::io

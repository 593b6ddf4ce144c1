// The other routers of a fleet over DDS (Fast DDS): their discovery, and datagrams to and from
// them. Everything runs on the loop, except for slow operations of the library, which run in a
// thread of the engine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "router/io/log.h"
#include "router/io/loop.h"
#include "router/link/datagram.h"
#include "router/link/transport.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::io {

struct DdsSettings {
  std::string fleet{};    // routers of other fleets are ignored
  unsigned domain = 0;    // at most 232
  bool multicast = true;  // discover routers of this network by multicast
  // Possible addresses of routers that multicast does not reach: "10.9.1.1" or "10.9.1.1:7410".
  std::vector<std::string> peers{};
  // "10.9.1.1:11811": a discovery server (of id 0) announces all routers; with it, no other
  // discovery is used.
  std::string discovery_server{};
  // The only address at which this host can be reached: "10.9.1.4"; empty: all of them.
  std::string interface {};
  std::string profiles{};                     // a file of XML profiles; those named "tims" are used
  Duration lease = std::chrono::seconds(10);  // a router that is silent for as long is gone
  // Messages larger than the network's MTU are sent as IP fragments.
  std::uint32_t message_max = 1392;
  std::uint32_t history = 32;  // samples one router may leave unacknowledged
  // Interval of heartbeats to a router that has not acknowledged everything.
  Duration heartbeat = std::chrono::milliseconds(2);
};

class DdsEngine {
 public:
  enum class State : std::uint8_t {
    kOff,
    kStarting,  // also after a failure, which is followed by an automatic retry
    kUp,
  };

  struct Counters {
    std::uint64_t samples_out = 0;
    std::uint64_t bytes_out = 0;  // of datagrams, without overhead
    std::uint64_t datagrams_out = 0;
    std::uint64_t samples_in = 0;
    std::uint64_t bytes_in = 0;
    std::uint64_t datagrams_in = 0;
    std::uint64_t strange = 0;  // samples that could not be decoded
    std::uint64_t refused = 0;  // datagrams refused by send(): no room, or no such router
    // Accepted datagrams that were dropped: the receiver did not appear.
    std::uint64_t unmatched = 0;
    std::uint64_t waiting_bytes = 0;  // currently queued
  };

  // All calls are made on the loop's thread, from the loop. None of them may stop or destroy the
  // engine.
  class Listener {
   public:
    virtual ~Listener() = default;
    // The bytes may be modified and stay valid until on_turn_end() has returned.
    virtual void on_datagram(const link::NetAddress& from, std::span<std::byte> datagram) = 0;
    // Also called when a router's announcement has changed.
    virtual void on_announced(const link::Announcement& announcement) = 0;
    virtual void on_gone(const link::NetAddress& dds) = 0;
    // state(), address() or last_error() has changed.
    virtual void on_state() = 0;
    // Called after one or several of the calls above: their consequences can be sent now.
    virtual void on_turn_end() = 0;
  };

  // True when this router was built with Fast DDS: TIMS_WITH_DDS.
  static bool built_in();

  DdsEngine(Loop& loop, Log& log, DdsSettings settings, Listener& listener);
  DdsEngine(const DdsEngine&) = delete;
  DdsEngine& operator=(const DdsEngine&) = delete;
  ~DdsEngine();

  // Returns an error when the settings cannot work. All other failures are reported by on_state()
  // and retried.
  Result<void> start(const link::Announcement& self);
  // The addresses of this host or the announcement have changed: the participant is created
  // again, with a new address() (an existing one does not survive a change of addresses). Routers
  // stay known unless they are not announced again; queued datagrams stay queued.
  void restart(const link::Announcement& self);
  // Sends queued datagrams for at most 200 ms and notifies the others that this router has gone.
  // If the library does not shut down within some seconds, it is left running.
  void stop();

  [[nodiscard]] State state() const;
  // The address that others send to; none unless the state is up.
  [[nodiscard]] link::NetAddress address() const;
  // host_addresses() just before the participant was created, which announces those and no later
  // ones; none unless the state is up.
  [[nodiscard]] std::vector<link::NetAddress> host() const;
  // The reason why it is not up, or the library's last warning; empty: none.
  [[nodiscard]] const std::string& last_error() const;
  [[nodiscard]] Counters counters() const;

  // Prepares sending to an announced router; otherwise the first datagram does. With a discovery
  // server, the server must be reachable for this.
  void connect(const link::NetAddress& to);
  // Accepts the whole burst or nothing: returns false when there is no room now, or when no such
  // router was announced. Accepted datagrams arrive in order and are not lost, unless the
  // receiver does not appear within two seconds, or disappears.
  bool send(const link::Burst& burst);

 private:
  class Running;

  Loop& loop_;
  Log& log_;
  const DdsSettings settings_;
  Listener& listener_;
  std::unique_ptr<Running> running_;
  std::string last_error_;
};

constexpr std::string_view name(DdsEngine::State state) {
  switch (state) {
    case DdsEngine::State::kOff:
      return "off";
    case DdsEngine::State::kStarting:
      return "starting";
    case DdsEngine::State::kUp:
      return "up";
  }
  return {};
}

}  // namespace tims::io

// The other routers of a fleet by way of DDS (Fast DDS): who there is, and datagrams to and from
// them. All of it happens on the loop; what may take long in the library, a thread of the engine
// does.
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
  std::string fleet{};    // routers of other fleets are not seen
  unsigned domain = 0;    // 232 at most
  bool multicast = true;  // finds routers of this network without being told
  // Where routers may be that multicast does not reach: "10.9.1.1" or "10.9.1.1:7410".
  std::vector<std::string> peers{};
  // "10.9.1.1:11811": a discovery server (of id 0) tells who there is; nothing else is asked then.
  std::string discovery_server{};
  // Where this host can be reached, when not at all its addresses: "10.9.1.4".
  std::string interface {};
  std::string profiles{};                     // a file of XML profiles; those named "tims" count
  Duration lease = std::chrono::seconds(10);  // who is silent for as long is gone
  // Larger messages than the network takes go in IP fragments.
  std::uint32_t message_max = 1392;
  std::uint32_t history = 32;  // samples that one router has not acknowledged
  Duration heartbeat = std::chrono::milliseconds(2);  // to a router that has not acknowledged all
};

class DdsEngine {
 public:
  enum class State : std::uint8_t {
    kOff,
    kStarting,  // also after a failure: the next try follows by itself
    kUp,
  };

  struct Counters {
    std::uint64_t samples_out = 0;
    std::uint64_t bytes_out = 0;  // of datagrams, without what is around them
    std::uint64_t datagrams_out = 0;
    std::uint64_t samples_in = 0;
    std::uint64_t bytes_in = 0;
    std::uint64_t datagrams_in = 0;
    std::uint64_t strange = 0;    // samples that nobody understands
    std::uint64_t refused = 0;    // datagrams that send() did not take: no room, or nobody there
    std::uint64_t unmatched = 0;  // datagrams taken and thrown away: the receiver did not appear
    std::uint64_t waiting_bytes = 0;  // now, to be written
  };

  // All calls come on the loop's thread, from the loop. None may stop or destroy the engine.
  class Listener {
   public:
    virtual ~Listener() = default;
    // The bytes may be written to; they stay where they are until on_turn_end() has returned.
    virtual void on_datagram(const link::NetAddress& from, std::span<std::byte> datagram) = 0;
    // Also when something has changed in what a router says of itself.
    virtual void on_announced(const link::Announcement& announcement) = 0;
    virtual void on_gone(const link::NetAddress& dds) = 0;
    // state(), address() or last_error() is another one.
    virtual void on_state() = 0;
    // After one or several of the calls above: what follows from them can go out.
    virtual void on_turn_end() = 0;
  };

  // Whether this router was built with Fast DDS: TIMS_WITH_DDS.
  static bool built_in();

  DdsEngine(Loop& loop, Log& log, DdsSettings settings, Listener& listener);
  DdsEngine(const DdsEngine&) = delete;
  DdsEngine& operator=(const DdsEngine&) = delete;
  ~DdsEngine();

  // Refused when the settings cannot work. Everything else that can go wrong is told by
  // on_state(), and tried again.
  Result<void> start(const link::Announcement& self);
  // This host has got other addresses, or has something else to say of itself: the participant is
  // made anew (one that exists does not survive a change of addresses), with a new address().
  // Routers stay known unless they are not heard of again; what waits for them stays waiting.
  void restart(const link::Announcement& self);
  // What waits is sent, as far as it goes in 200 ms; the others hear that this router is gone. A
  // library that does not end is left behind after some seconds.
  void stop();

  [[nodiscard]] State state() const;
  // Our own, which others send to; none unless up.
  [[nodiscard]] link::NetAddress address() const;
  // Why it is not up, or what the library last complained about; empty: nothing.
  [[nodiscard]] const std::string& last_error() const;
  [[nodiscard]] Counters counters() const;

  // Prepares for sending to a router that was announced: else the first datagram does. Where a
  // discovery server is used, it must be there for that.
  void connect(const link::NetAddress& to);
  // Takes all of the burst, or nothing: false when there is no room for it now, or when no such
  // router was announced. What is taken arrives in order and is not lost, unless the receiver
  // does not appear within two seconds, or goes.
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

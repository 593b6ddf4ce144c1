// All connections with TLS of a program, in a thread of their own.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include <poll.h>

#include "os/file.h"
#include "security/relay/tls_relay.h"

namespace tims::security {

struct RelayLimits {
  std::size_t handshakes_max = 64;    // at once; beyond it, the oldest one ends
  std::size_t first_bytes_max = 256;  // connections of which nothing has come; likewise
  Duration handshake_time = std::chrono::seconds(5);  // and for the first byte
};

class TlsRelays {
 public:
  using Chain = std::vector<Certificate>;

  // kSystem: the thread's event cannot be made.
  static Result<std::unique_ptr<TlsRelays>> start(RelayLimits limits = {});
  TlsRelays(const TlsRelays&) = delete;
  TlsRelays& operator=(const TlsRelays&) = delete;
  // Ends all connections.
  ~TlsRelays();

  // For any thread.
  void add(Relayed what);
  // Ends the connections whose chain is one of these; empty: the other side showed no certificate.
  void end_if(std::function<bool(const Chain&)> which);

 private:
  using Order = std::function<void(Time now)>;

  TlsRelays(os::File event, RelayLimits limits);
  void give(Order order);
  void run();
  void obey(Time now);
  void begin(Time now, Relayed what);
  void make_room(TlsRelay::State state, std::size_t most);
  void tidy();
  void wait();
  void work();

  RelayLimits limits_;
  os::File event_;
  std::mutex mutex_;
  std::vector<Order> orders_;   // under mutex_
  bool stopping_ = false;       // likewise
  std::list<TlsRelay> relays_;  // oldest first
  std::vector<pollfd> waits_;   // the event, then two for each relay
  std::thread thread_;
};

}  // namespace tims::security

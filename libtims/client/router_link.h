// The connection to the router: one thread that connects, greets, receives answers, and connects
// again when the router went away. Requests may come from any thread.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "client/tcp_bridge.h"
#include "os/file.h"
#include "tims/result.h"
#include "tims/session.h"
#include "tims/time.h"
#include "wire/endpoint.h"
#include "wire/local_protocol.h"

namespace tims::client {

struct Answer {
  wire::Record record;
  std::vector<os::File> files;
};

// Asks and waits, on a connection that is not shared yet; not longer than until `stop` is readable.
class Greeting {
 public:
  Greeting(int socket, int stop) : socket_(socket), stop_(stop) {}
  Result<void> tell(const wire::Record& record, std::span<const int> files = {}) const;
  Result<Answer> ask(const wire::Record& record, std::span<const int> files = {});

 private:
  int socket_;
  int stop_;
};

class RouterLink {
 public:
  // What the session does on the link's own thread.
  class Listener {
   public:
    virtual ~Listener() = default;
    // Connected (again): register everything. What fails is tried again with another connection.
    virtual Result<void> greet(Greeting& greeting) = 0;
    virtual void lost() = 0;
    virtual void moved(Address address) = 0;
    // Answers what was asked by ask_later(); the newest connection's.
    virtual void found(const wire::Found& found, Answer& answer) = 0;
    virtual void event(SessionEvent::Kind kind, const std::string& text) = 0;
  };

  struct Settings {
    wire::Endpoint router;
    std::string name;                   // of this program
    std::uint32_t tcp_message_max = 0;  // header included
    int tcp_priority = 0;
  };
  RouterLink(Settings settings, Listener& listener);
  ~RouterLink();

  void start();
  // Until connected, or refused for good, or the deadline.
  Result<void> wait_connected(Time deadline);

  // Sends a request and waits for `answers` records. kNoRouter: not connected, or lost meanwhile,
  // or no answer within `patience`: the default for what a sender waits for.
  static constexpr Duration kAnswerTimeout = std::chrono::seconds(5);
  Result<std::vector<Answer>> exchange(const wire::Record& record, std::span<const int> files,
                                       std::size_t answers, Duration patience = kAnswerTimeout);
  // Asks where an address is, and never waits, not even for another thread that asks. False: it
  // could not be sent now. The listener gets the answer.
  bool ask_later(Address address);

  // Counts the routers met so far; 0: none yet. Cheap.
  [[nodiscard]] std::uint64_t connection() const {
    return connection_.load(std::memory_order_acquire);
  }
  [[nodiscard]] bool connected() const { return connected_.load(std::memory_order_acquire); }
  [[nodiscard]] Time connected_at() const;
  [[nodiscard]] wire::Welcome welcome() const;

 private:
  struct Pending {
    std::size_t expected = 0;
    std::vector<Answer> answers;
    bool failed = false;
  };

  // Until `settled`; false: not within that time.
  template <typename Settled>
  bool wait(std::unique_lock<std::mutex>& lock, Duration patience, Settled settled) {
    if (patience != kForever) return changed_.wait_for(lock, patience, settled);
    changed_.wait(lock, settled);
    return true;
  }
  void run();
  Result<void> connect();
  Result<os::File> dial();
  Result<os::File> dial(const wire::TcpEndpoint& router);
  Result<void> hello(int socket);
  void serve();
  bool receive();
  void dispatch(wire::Packet packet, std::vector<os::File> files);
  void disconnect();
  bool stopping_within(Duration wait);

  const Settings settings_;
  const std::string where_;  // the router, for people
  Listener& listener_;
  os::File stop_;                      // eventfd
  std::unique_ptr<TcpBridge> bridge_;  // of the last connection over TCP
  std::vector<std::byte> buffer_;

  mutable std::mutex mutex_;  // what follows
  std::condition_variable changed_;
  os::File socket_;
  wire::Welcome welcome_;
  Time connected_at_{};
  std::map<std::uint32_t, Pending*> pending_;
  std::uint32_t last_request_ = 0;
  std::optional<Error> refused_;

  std::atomic<bool> connected_ = false;
  std::atomic<std::uint64_t> connection_ = 0;
  std::thread thread_;
};

}  // namespace tims::client

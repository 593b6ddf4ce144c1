// The connection to the router. One thread connects, registers, receives answers, and reconnects
// when the connection is lost. Requests may come from any thread.
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

// Sends requests and waits for the answers on a connection that is not shared yet; ends early when
// `stop` is readable.
class Greeting {
 public:
  Greeting(int socket, int stop) : socket_(socket), stop_(stop) {}
  Result<void> send(const wire::Record& record, std::span<const int> files = {}) const;
  Result<Answer> ask(const wire::Record& record, std::span<const int> files = {}) const;

 private:
  int socket_;
  int stop_;
};

// `go_on` has ended a call.
inline Error ended_early() { return {Errc::kTimeout, "the call was ended while it waited"}; }

class RouterLink {
 public:
  // Callbacks of the session on the link's own thread.
  class Listener {
   public:
    virtual ~Listener() = default;
    // Connected (again): registers everything. If it fails, the link tries again with a new
    // connection.
    virtual Result<void> greet(Greeting& greeting) = 0;
    virtual void lost() = 0;
    virtual void moved(Address address) = 0;
    // The answer to ask_later(), on the newest connection.
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
  // Waits until connected, finally refused, or the deadline.
  Result<void> wait_connected(Time deadline);
  // The same until `go_on`, asked after each slice, returns false: kTimeout.
  Result<void> wait_connected(const GoOn& go_on);
  static constexpr Duration kSlice = std::chrono::milliseconds(50);

  // Sends a request and waits for `answers` records. kNoRouter: not connected, connection lost
  // during the call, or no answer within `patience`; the default suits requests that a sender waits
  // for.
  static constexpr Duration kAnswerTimeout = std::chrono::seconds(5);
  Result<std::vector<Answer>> exchange(const wire::Record& record, std::span<const int> files,
                                       std::size_t answers, Duration patience = kAnswerTimeout);
  // Waits without limit, until `go_on`, asked after each slice, returns false: kTimeout. An answer
  // that comes later is ignored.
  Result<std::vector<Answer>> exchange(const wire::Record& record, std::span<const int> files,
                                       std::size_t answers, const GoOn& go_on);
  // Requests the location of an address. Never waits, not even for another thread that is sending a
  // request. False: it could not be sent now. The listener receives the answer.
  bool ask_later(Address address);

  // Number of connections so far; 0: none yet. Cheap.
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

  // Waits until `settled`; false when the time is over.
  template <typename Settled>
  bool wait(std::unique_lock<std::mutex>& lock, Duration patience, Settled settled) {
    if (patience != kForever) return changed_.wait_for(lock, patience, settled);
    changed_.wait(lock, settled);
    return true;
  }
  // Sends it and calls wait_for_answers(lock, settled), which returns whether it is settled.
  template <typename Wait>
  Result<std::vector<Answer>> exchange_with(const wire::Record& record, std::span<const int> files,
                                            std::size_t answers, Wait wait_for_answers);
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
  const std::string where_;  // the router, for messages
  Listener& listener_;
  os::File stop_;                      // eventfd
  std::unique_ptr<TcpBridge> bridge_;  // of the last connection over TCP
  std::vector<std::byte> buffer_;

  mutable std::mutex mutex_;  // protects the members below
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

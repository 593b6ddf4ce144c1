// Subscriptions to the data of Dora's components. On each host, a mailbox and a real-time thread
// receive the messages and note when they arrive.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rack/proxies/generic.h"
#include "rack/thread.h"
#include "tims/session.h"
#include "tools/cli/connection.h"

namespace rack::dora {

using tims::Duration;
using tims::Time;

// The components of table III of the paper, and the world's true state.
struct Stream {
  std::string_view component;
  std::string_view host;
  double period_ms;
  bool from_a_line = false;  // its data comes, directly or indirectly, from a serial device
};
inline constexpr std::size_t kComponents = 10;
inline constexpr std::array<Stream, kComponents + 1> kStreams = {{
    {"Chassis(1/0)", "robot1-drive", 50, true},
    {"Odometry(1/0)", "robot1-drive", 50, true},
    {"Position(1/0)", "robot1-drive", 50, true},
    {"Pilot(1/0)", "robot1-drive", 50},
    {"Ladar(1/0)", "robot1-laser", 1000.0 / 75, true},
    {"Gps(1/0)", "robot1-nav", 2000, true},
    {"Gyro(1/0)", "robot1-drive", 100, true},
    {"Scan2d(1/0)", "robot1-laser", 1000.0 / 75, true},
    {"Path(1/0)", "robot1-nav", 50},
    {"Mcl(1/0)", "robot1-nav", 1000},
    {"World(1/0)", "base", 20},
}};
inline constexpr std::array<std::string_view, 3> kHosts = {"robot1-drive", "robot1-laser",
                                                           "robot1-nav"};
inline constexpr std::string_view kBase = "base";

// Throws timsctl::Failure when the text is not a component address.
tims::Address address_of(std::string_view component);

// All subscriptions on one host.
class Subscriptions {
 public:
  // Receives data, and type::kError when the producer was turned off or failed. Called by the
  // receiving thread; the message is valid only during the call.
  using OnMessage = std::function<void(std::size_t stream, const tims::MessageView&, Time)>;

  // Connects to the router at `socket`. Throws timsctl::Failure.
  Subscriptions(std::string_view host, const std::string& socket, OnMessage on_message);
  ~Subscriptions();
  Subscriptions(const Subscriptions&) = delete;
  Subscriptions& operator=(const Subscriptions&) = delete;

  // Subscribes again to each component that has sent nothing for a while. Call it repeatedly.
  void renew();
  // Opens a mailbox in the same session.
  tims::Mailbox open(const tims::MailboxOptions& options);
  // For requests by the main thread.
  [[nodiscard]] tims::Mailbox& work() { return *work_; }
  // False if the receiving thread has no real-time priority: its arrival times are then late, too.
  [[nodiscard]] bool is_real_time() const { return real_time_; }

 private:
  struct Subscription {
    std::size_t stream = 0;
    tims::Address component;
    Duration timeout{};
    std::atomic<Time::rep> last_received{0};
    Time requested{};
  };
  void receive();

  OnMessage on_message_;
  tims::Session session_;
  std::optional<tims::Mailbox> work_;
  std::optional<tims::Mailbox> stream_;
  std::vector<std::unique_ptr<Subscription>> subscribed_;
  std::atomic<bool> ending_ = false;
  bool real_time_ = false;
  Thread thread_;
};

}  // namespace rack::dora

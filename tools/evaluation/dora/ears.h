// What Dora's components say, stamped where it arrives: at each host a mailbox of ours, and a
// thread that nothing else keeps from waking.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "components/runtime/thread.h"
#include "rack/proxies/generic.h"
#include "tims/session.h"
#include "tools/cli/connection.h"

namespace rack::dora {

using tims::Duration;
using tims::Time;

// Table III of the paper, and the truth.
struct Stream {
  std::string_view component;
  std::string_view host;
  double period_ms;
  bool from_a_line = false;  // its driver's device is behind one, or it works on what that says
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

// Throws timsctl::Failure when it is none.
tims::Address address_of(std::string_view component);

// Of one host.
class Ears {
 public:
  // Data, and that its producer went off or failed (type::kError). Called by its thread; what it is
  // given is gone afterwards.
  using Hear = std::function<void(std::size_t stream, const tims::MessageView&, Time)>;

  // At the router of that socket. Throws timsctl::Failure.
  Ears(std::string_view host, const std::string& socket, Hear hear);
  ~Ears();
  Ears(const Ears&) = delete;
  Ears& operator=(const Ears&) = delete;

  // Asks those for data that have been silent, again and again.
  void keep();
  // Of its session.
  tims::Mailbox open(const tims::MailboxOptions& options);
  // For calls of the main thread.
  [[nodiscard]] tims::Mailbox& work() { return *work_; }
  // Without a real-time priority it is as late as others are.
  [[nodiscard]] bool is_real_time() const { return real_time_; }

 private:
  struct Heard {
    std::size_t stream = 0;
    tims::Address component;
    Duration patience{};
    std::atomic<Time::rep> last{0};
    Time asked{};
  };
  void listen();

  Hear hear_;
  tims::Session session_;
  std::optional<tims::Mailbox> work_;
  std::optional<tims::Mailbox> stream_;
  std::vector<std::unique_ptr<Heard>> heard_;
  std::atomic<bool> ending_ = false;
  bool real_time_ = false;
  Thread thread_;
};

}  // namespace rack::dora

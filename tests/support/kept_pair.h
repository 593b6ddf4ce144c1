// A base and a robot on two hosts, whose routers are run as by systemd, with numbered commands in
// both directions between their programs.
#pragma once

#include <array>
#include <csignal>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/descriptor_keeper.h"
#include "tests/support/numbered_traffic.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/two_networks.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::test {

class KeptPair {
 public:
  // Without keys, and by UDP, unless the settings of the routers say otherwise.
  struct Settings {
    std::string keys_base{};   // "security.keys=FOLDER"
    std::string keys_robot{};  // likewise
    std::string path{};        // of the link: "tcp"
  };
  // `networks`: must outlive it; the calling thread is in the left one.
  KeptPair(const TwoNetworks& networks, const Settings& settings);

  // Both routers and the programs, until commands arrive.
  Result<void> start();
  Result<void> begin_traffic();

  // SIGUSR2: for an upgrade. SIGKILL: as after a crash.
  Result<void> restart(KeptRouter& router, int signal = SIGUSR2);
  // The next router finds the state of another version of this program.
  Result<void> restart_with_other_layout(KeptRouter& router);
  // Until so many more have arrived in each direction.
  Result<void> wait_for_more(std::uint64_t count);
  // The traffic ends, when all has arrived or after this time.
  void end(Duration patience);

  [[nodiscard]] KeptRouter& base() { return base_; }
  [[nodiscard]] KeptRouter& robot() { return robot_; }
  // From the robot to the base, and from the base to the robot.
  [[nodiscard]] std::array<std::unique_ptr<NumberedTraffic>, 2>& traffic() { return traffic_; }
  [[nodiscard]] std::string output() const;  // of the routers

 private:
  template <typename Act>
  auto on(const KeptRouter& router, Act act) const {
    return &router == &robot_ ? networks_.on_the_right(act) : act();
  }

  const TwoNetworks& networks_;
  TemporaryFolder base_folder_;
  TemporaryFolder robot_folder_;
  KeptRouter base_;
  KeptRouter robot_;
  std::array<std::unique_ptr<NumberedTraffic>, 2> traffic_;
};

}  // namespace tims::test

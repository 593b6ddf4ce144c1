// A simulated robot: real components around a real router, and proxies to all of them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "proxies/chassis.h"
#include "proxies/pilot.h"
#include "proxies/position.h"
#include "tests/support/child_process.h"
#include "tests/support/eventually.h"
#include "tests/system/local_fixture.h"

namespace tims::test {

class RobotTest : public LocalTest {
 protected:
  void SetUp() override {
    LocalTest::SetUp();
    session_.emplace(session());
    work_.emplace(open(*session_, 0x000F0100, {.slots = 4, .body_max = 1U << 20}));
  }

  // Of bin/, ready for commands.
  void start(const std::string& program, std::vector<std::string> arguments = {}) {
    arguments.insert(arguments.begin(), {std::string(PROGRAMS) + "/" + program, "--router",
                                         router_.socket_path(), "--errorTimeout", "100"});
    auto started = ChildProcess::start(arguments);
    ASSERT_TRUE(started.ok()) << started.error().message();
    programs_.insert_or_assign(program, std::move(*started));
  }
  void kill(const std::string& program) {
    EXPECT_TRUE(programs_.at(program).stop(SIGKILL).ok());
    programs_.erase(program);
  }

  template <typename Proxy>
  Proxy proxy(const std::string& address) {
    return Proxy(*work_, *Address::parse(address));
  }
  // Programs take a while to start.
  testing::AssertionResult turned_on(const std::string& address) {
    rack::Proxy component(*work_, *Address::parse(address));
    return eventually([&]() -> std::string {
      const auto on = component.on();
      return on ? "" : address + " is not on: " + on.error().message();
    });
  }

  std::optional<Session> session_;
  std::optional<Mailbox> work_;
  std::map<std::string, ChildProcess> programs_;
};

}  // namespace tims::test

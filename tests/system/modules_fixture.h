// Programs of components at a router of the test's own, and proxies to talk to them.
#pragma once

#include <csignal>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/child_process.h"
#include "tests/system/local_fixture.h"

namespace tims::test {

class ModulesTest : public LocalTest {
 protected:
  static constexpr std::uint32_t kWork = 0x00020001;

  void SetUp() override {
    LocalTest::SetUp();
    session_.emplace(session());
    work_.emplace(open(*session_, kWork, {.body_max = 1 << 20}));
  }

  [[nodiscard]] ChildOptions at_router() const {
    return {.environment = {"TIMS_ROUTER=" + router_.socket_path()}, .folder = {}};
  }
  // Of bin/, until its mailbox is there: what it says first.
  ChildProcess& start(const std::string& program, std::vector<std::string> arguments = {}) {
    std::vector<std::string> command{std::string(TIMS_PROGRAMS) + "/" + program};
    command.insert(command.end(), arguments.begin(), arguments.end());
    auto child = ChildProcess::start(std::move(command), at_router());
    EXPECT_TRUE(child) << child.error().message();
    ChildProcess& kept = programs_.emplace(program, std::move(child).value())->second;
    const auto ready = kept.wait_for_line("Init");
    EXPECT_TRUE(ready) << ready.error().message();
    return kept;
  }
  void kill(const std::string& program) {
    const auto oldest = programs_.find(program);
    ASSERT_NE(oldest, programs_.end()) << program;
    EXPECT_TRUE(oldest->second.stop(SIGKILL));
    programs_.erase(oldest);
  }

  template <typename P>
  P proxy(std::uint32_t address) {
    return P(*work_, Address(address), {.on = kPatience, .off = kPatience, .data = kPatience});
  }

  std::optional<Session> session_;
  std::optional<Mailbox> work_;

 private:
  std::multimap<std::string, ChildProcess> programs_;
};

}  // namespace tims::test

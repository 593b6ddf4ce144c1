// Programs of components at the test's own router, and proxies for them.
#pragma once

#include <csignal>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <sys/socket.h>

#include "os/file.h"
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
  // Starts a program of bin/ and waits until its mailbox exists, which its first line reports.
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
  // Starts rack-emulate NAME ADDRESS and waits until it is ready.
  static ChildProcess emulate(const std::string& name, const std::string& address) {
    auto child = ChildProcess::start({std::string(TIMS_PROGRAMS) + "/rack-emulate", name, address});
    EXPECT_TRUE(child) << child.error().message();
    const auto ready = child->wait_for_line("for driver");
    EXPECT_TRUE(ready) << ready.error().message();
    return std::move(*child);
  }
  // A free port for SOCK_STREAM or SOCK_DGRAM.
  static std::string free_port(int kind) {
    const os::File socket(::socket(AF_INET, kind, 0));
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof any;
    EXPECT_EQ(::bind(socket.get(), reinterpret_cast<const sockaddr*>(&any), size), 0);
    EXPECT_EQ(::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&any), &size), 0);
    return std::to_string(ntohs(any.sin_port));
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

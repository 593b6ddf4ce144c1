// The ports with TLS as testssl.sh sees them (package testssl.sh): no version, cipher or habit that
// it finds fault with, but for what is meant so.
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <boost/json/parse.hpp>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "os/file.h"
#include "tests/support/child_process.h"
#include "tests/support/fleet_keys.h"
#include "tests/support/router_process.h"
#include "tests/support/temporary_folder.h"

namespace tims::test::tls_ports_test {

namespace json = boost::json;

constexpr const char* kProgram = "/usr/bin/testssl";
constexpr std::chrono::seconds kLimit(280);  // testssl.sh starts thousands of programs
// A fleet is its own authority, and lists what it revokes itself; no expiry stops a robot.
// What OpenSSL's program on this host lacks is no fault of the ports.
constexpr std::array<std::string_view, 5> kMeantSo{"cert_trust", "cert_chain_of_trust",
                                                   "cert_validityPeriod", "cert_revocation",
                                                   "engine_problem"};
// What is compressed are files of the console, which are the same for everybody and hold no secret.
constexpr std::string_view kOfHttps = "BREACH";
// Who has no certificate is refused: often before the program behind testssl.sh sees that it was
// connected.
constexpr std::string_view kOfTcp = "optimal_proto";
// The TCP port speaks no protocol that it knows.
constexpr std::string_view kNoFinding = "DEBUG";

class TlsPorts : public testing::Test {
 protected:
  void SetUp() override {
    if (::access(kProgram, X_OK) != 0) GTEST_SKIP() << "needs the package testssl.sh";
    const auto started = router_.start();
    ASSERT_TRUE(started.ok()) << started.error().message();
  }
  // A run of testssl.sh takes half a minute, or some on a slow machine.
  struct Look {
    std::string report;
    Result<ChildProcess> program;
  };
  Look look_at(const std::string& port, const std::string& name,
               const std::vector<std::string>& what) {
    const std::string report = folder_.path() / (name + ".json");
    std::vector<std::string> command{kProgram, "--quiet", "--color", "0",          "--warnings",
                                     "off",    "--nodns", "none",    "--jsonfile", report};
    command.insert(command.end(), what.begin(), what.end());
    command.push_back(port);
    return {.report = report, .program = ChildProcess::start(command)};
  }
  // What is worse than remarkable and not `meant` so, "severity id: finding" each.
  static std::vector<std::string> faults_in(Look& look, std::string_view meant) {
    EXPECT_TRUE(look.program && look.program->wait(kLimit));
    const auto text = os::read_file(look.report);
    EXPECT_TRUE(text) << look.program->output();
    boost::system::error_code error;
    const json::value findings = json::parse(text ? *text : "", error);
    EXPECT_TRUE(!error && findings.is_array() && findings.as_array().size() > 20)
        << look.program->output();
    std::vector<std::string> faults;
    if (!findings.is_array()) return faults;
    for (const json::value& one : findings.as_array()) {
      const std::string severity(one.at("severity").as_string());
      const std::string id(one.at("id").as_string());
      const bool is_fault = severity != "OK" && severity != "INFO" && severity != kNoFinding;
      if (!is_fault || id == meant || std::ranges::find(kMeantSo, id) != kMeantSo.end()) continue;
      faults.push_back(
          fmt::format("{} {}: {}", severity, id, one.at("finding").as_string().c_str()));
    }
    return faults;
  }

  FleetKeys keys_;
  TemporaryFolder folder_;
  RouterProcess router_{{keys_.base(), "router.role=top", "router.system=0", "router.id=1",
                         "http.listen=127.0.0.1:0"}};
};

// Both have the same keys, protocols and ciphers, so what these are vulnerable to is tried once.
TEST_F(TlsPorts, HaveNoFaults) {
  Look https = look_at(router_.http(), "https",
                       {"--protocols", "--server-defaults", "--fs", "--vulnerable"});
  Look tcp = look_at(router_.tcp(), "tcp", {"--protocols", "--server-defaults"});
  EXPECT_THAT(faults_in(https, kOfHttps), testing::IsEmpty());
  EXPECT_THAT(faults_in(tcp, kOfTcp), testing::IsEmpty());
}

}  // namespace tims::test::tls_ports_test

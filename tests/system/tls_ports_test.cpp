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
#include "tests/support/router_process.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/fleet_keys.h"

namespace tims::test::tls_ports_test {

namespace json = boost::json;

constexpr const char* kProgram = "/usr/bin/testssl";
constexpr std::chrono::minutes kLimit(4);
// A fleet is its own authority, and lists what it revokes itself; no expiry stops a robot.
// What is compressed are files of the console, which are the same for everybody and hold no secret.
// At the TCP port, who has no certificate is refused: often before the program behind testssl.sh
// sees that it was connected ("optimal_proto").
constexpr std::array<std::string_view, 6> kMeantSo{
    "cert_trust", "cert_chain_of_trust", "cert_validityPeriod", "cert_revocation",
    "BREACH",     "optimal_proto"};
// The TCP port speaks no protocol that it knows.
constexpr std::string_view kNoFinding = "DEBUG";

class TlsPorts : public testing::Test {
 protected:
  void SetUp() override {
    if (::access(kProgram, X_OK) != 0) GTEST_SKIP() << "needs the package testssl.sh";
    const auto started = router_.start();
    ASSERT_TRUE(started.ok()) << started.error().message();
  }
  // What is worse than remarkable, "severity id: finding" each.
  std::vector<std::string> faults_of(const std::string& port) {
    const std::string report = folder_.path() / "report.json";
    auto child =
        ChildProcess::start({kProgram, "--quiet", "--color", "0", "--warnings", "off", "--nodns",
                             "none", "--protocols", "--server-defaults", "--server-preference",
                             "--fs", "--vulnerable", "--jsonfile", report, port});
    EXPECT_TRUE(child && child->wait(kLimit));
    const auto text = os::read_file(report);
    EXPECT_TRUE(text) << child->output();
    boost::system::error_code error;
    const json::value findings = json::parse(text ? *text : "", error);
    EXPECT_TRUE(!error && findings.is_array() && findings.as_array().size() > 20)
        << child->output();
    std::vector<std::string> faults;
    if (!findings.is_array()) return faults;
    for (const json::value& one : findings.as_array()) {
      const std::string severity(one.at("severity").as_string());
      const std::string id(one.at("id").as_string());
      const bool is_fault = severity != "OK" && severity != "INFO" && severity != kNoFinding;
      if (!is_fault || std::ranges::find(kMeantSo, id) != kMeantSo.end()) continue;
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

TEST_F(TlsPorts, Https) { EXPECT_THAT(faults_of(router_.http()), testing::IsEmpty()); }

TEST_F(TlsPorts, Tcp) { EXPECT_THAT(faults_of(router_.tcp()), testing::IsEmpty()); }

}  // namespace tims::test::tls_ports_test

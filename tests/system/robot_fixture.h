// A simulated robot: real components at a real router, and proxies for all of them.
#pragma once

#include <string>
#include <vector>

#include "rack/proxies/chassis.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/position.h"
#include "tests/support/eventually.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {

class RobotTest : public ModulesTest {
 protected:
  // Starts components with a short retry interval after errors.
  void start(const std::string& program, std::vector<std::string> arguments = {}) {
    arguments.insert(arguments.begin(), "--errorTimeout=100");
    ModulesTest::start(program, std::move(arguments));
  }

  template <typename Proxy>
  Proxy proxy(const std::string& address) {
    return Proxy(*work_, *Address::parse(address));
  }
  // Retries, because the components it needs may not be ready yet.
  testing::AssertionResult turned_on(const std::string& address) {
    rack::Proxy component(*work_, *Address::parse(address));
    return eventually([&]() -> std::string {
      const auto on = component.on();
      return on ? "" : address + " is not on: " + on.error().message();
    });
  }
};

}  // namespace tims::test

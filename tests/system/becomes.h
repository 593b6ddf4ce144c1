// Waits for a state of a component.
#pragma once

#include <string>

#include "rack/proxies/proxy.h"
#include "tests/support/eventually.h"

namespace tims::test {

inline testing::AssertionResult becomes(Mailbox& work, const std::string& address,
                                        rack::Status wanted) {
  rack::Proxy component(work, *Address::parse(address));
  return eventually([&]() -> std::string {
    const auto status = component.status();
    if (!status) return status.error().message();
    return *status == wanted ? "" : address + " is " + std::string(name(*status));
  });
}

}  // namespace tims::test

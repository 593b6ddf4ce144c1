// A minimal implementation of the original TCP router (specification, section 3) in its own thread,
// with optional faults that a replay must find.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "os/file.h"
#include "tims/message.h"
#include "tims/time.h"

namespace tims::test {

enum class Fault {
  kNone,
  kLosesMessage,
  kRepeatsMessage,
  kAltersBody,
  kAltersPriority,
  kSwapsMessages,         // two successive ones from one connection to another
  kHangsUp,               // closes the sender's connection
  kAnswersReplies,        // NOT_AVAILABLE for type <= 0 as well
  kRegistersTwice,        // OK for an address that has an owner
  kKeepsMailboxes,        // of closed connections
  kKeepsTooLongMessages,  // waits for the rest instead of closing
  kNeverClosesSilent,     // has no watchdog
};

struct ModelRouterOptions {
  std::uint32_t message_max = 262144;
  Duration beat = std::chrono::seconds(5);  // of the watchdog
  Fault fault = Fault::kNone;
  // Faults of a single message apply to the first message for which this is true.
  std::function<bool(const Header&)> befalls = [](const Header&) { return true; };
};

class ModelRouter {
 public:
  explicit ModelRouter(const ModelRouterOptions& options);
  ~ModelRouter();  // as with kill -9

  [[nodiscard]] const std::string& endpoint() const { return endpoint_; }

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
  std::string endpoint_;
  os::File stop_;
  std::thread thread_;
};

}  // namespace tims::test

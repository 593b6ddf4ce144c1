// The rules of the original TCP router (specification, section 3) in the fewest lines: what the
// replay is tried on, with faults that it must find. In a thread of its own.
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
  kSwapsMessages,         // two that follow each other from one connection to another
  kHangsUp,               // on the sender
  kAnswersReplies,        // NOT_AVAILABLE for type <= 0, too
  kRegistersTwice,        // OK for an address that has an owner
  kKeepsMailboxes,        // of connections that have closed
  kKeepsTooLongMessages,  // waits for the rest instead of closing
  kNeverClosesSilent,     // has no watchdog
};

struct ModelRouterOptions {
  std::uint32_t message_max = 262144;
  Duration beat = std::chrono::seconds(5);  // of the watchdog
  Fault fault = Fault::kNone;
  // Which message the fault befalls, where it befalls one: the first of these.
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

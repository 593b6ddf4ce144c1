#include "tools/timsctl/connection.h"

#include <random>

#include "os/clock.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

tims::Address tool_address(std::uint32_t system) {
  std::random_device random;
  return tims::Address::of({.system = system,
                            .class_id = tims::class_id::kTool,
                            .instance = 1 + random() % 255,
                            .local = random() % 256});
}

std::optional<Message> receive(Connection& connection, const Signals& signals, tims::Time deadline,
                               std::optional<std::uint64_t> losses) {
  for (;;) {
    auto message = connection.take();
    if (message) return std::move(*message);
    if (message.error().code() != tims::Errc::kEmpty)
      throw failure_of(message.error(), connection.where());
    if (losses && connection.losses() != *losses)
      throw failure_of({tims::Errc::kNoRouter, "the router went away"}, connection.where());
    if (signals.wait(connection.descriptor(), deadline) == Signals::Woken::kTimeout &&
        tims::os::now() >= deadline)
      return std::nullopt;
  }
}

}  // namespace timsctl

#include "tools/timsctl/connection.h"

#include <random>

#include "os/clock.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

tims::Address mailbox_address(const MailboxWish& wish, std::uint32_t system,
                              const tims::AddressWidths& widths) {
  if (!wish.address.empty()) return need_address(wish.address, widths);
  std::random_device random;
  return tims::Address::of({.system = system,
                            .class_id = tims::class_id::kTool,
                            .instance = random(),
                            .local = random()},
                           widths);
}

bool may_draw_again(const MailboxWish& wish, int taken) {
  constexpr int kTries = 16;
  return wish.address.empty() && taken < kTries;
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

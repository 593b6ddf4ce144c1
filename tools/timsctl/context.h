// What a command has at hand.
#pragma once

#include <memory>

#include "tools/timsctl/admin_client.h"
#include "tools/timsctl/connection.h"
#include "tools/timsctl/options.h"
#include "tools/timsctl/output.h"
#include "tools/timsctl/signals.h"

namespace timsctl {

class Context {
 public:
  Context(const Options& command_line, Output& output, const Signals& interrupts, Host router)
      : options(command_line), out(output), signals(interrupts), host(std::move(router)) {}

  const Options& options;
  Output& out;
  const Signals& signals;
  const Host host;

  // When it ends by itself, counted from now: --for. kNever: it does not.
  [[nodiscard]] tims::Time run_end() const;

  // A mailbox at the router. Throws Failure.
  [[nodiscard]] std::unique_ptr<Connection> connect(const MailboxWish& wish = {}) const;
  // Asks the router of the connection, or that of --router.
  [[nodiscard]] AdminClient admin(Connection& connection) const;
};

// Throw Failure when the argument is none.
tims::Address need_address(std::string_view text, const tims::AddressWidths& widths);
std::vector<tims::Address> need_addresses(const std::vector<std::string>& texts,
                                          const tims::AddressWidths& widths);
tims::AddressPattern need_pattern(std::string_view text, const tims::AddressWidths& widths);
// A class by name ("Chassis"), or that of an address ("Chassis/0/0").
std::uint32_t need_class(std::string_view text);
// Of a message to a component of the class: its own names too.
std::int8_t need_type(std::string_view text, std::uint32_t class_id);

}  // namespace timsctl

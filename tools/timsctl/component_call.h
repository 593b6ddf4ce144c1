// A command to a component and its answer: one question at a time on a connection.
#pragma once

#include <span>
#include <vector>

#include "tools/timsctl/connection.h"
#include "tools/timsctl/context.h"

namespace timsctl {

class ComponentCall {
 public:
  ComponentCall(Context& context, Connection& connection)
      : context_(context), connection_(connection) {}

  // Throws Failure: nobody has the address, no answer in time. ERROR is an answer.
  Message ask(tims::Address component, std::int8_t type, std::span<const std::byte> body = {},
              std::optional<tims::Duration> timeout = {});

  // The states of many at once, in their order; who does not answer in time has none.
  std::vector<std::optional<std::int8_t>> states(std::span<const tims::Address> components);

  [[nodiscard]] std::string name_of(tims::Address address) const {
    return address.to_string(connection_.widths());
  }

 private:
  Context& context_;
  Connection& connection_;
};

// "on", "off", "error"; "answer -7" for what is none of these.
std::string state_text(std::int8_t state);

}  // namespace timsctl

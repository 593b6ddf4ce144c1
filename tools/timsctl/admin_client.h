// Asks a router by JSON (router/io/ADMIN.md).
#pragma once

#include <optional>
#include <string_view>

#include "tools/timsctl/connection.h"
#include "tools/timsctl/json.h"

namespace timsctl {

class AdminClient {
 public:
  AdminClient(Connection& connection, const Signals& signals, tims::Duration timeout)
      : connection_(connection), signals_(signals), timeout_(timeout) {}

  [[nodiscard]] tims::Address own_address() const { return connection_.address(); }

  // The answer, all its pages in one, with "age_ms". `patience` is what the router was asked to
  // wait. Throws Failure: no answer, not understood, or what the router says is wrong.
  json::object ask(const json::object& question, tims::Duration patience = {});

 private:
  json::object ask_once(const json::object& question, tims::Duration patience);

  Connection& connection_;
  const Signals& signals_;
  tims::Duration timeout_;
  std::uint8_t seq_nr_ = 0;
};

}  // namespace timsctl

// The routers of a fleet, asked over their sockets.
#pragma once

#include <optional>
#include <string>

#include "tools/timsctl/context.h"
#include "tools/timsctl/sim/plan.h"

namespace timsctl::sim {

class Routers {
 public:
  Routers(const Context& context, const Plan& plan) : context_(context), plan_(plan) {}

  // Asks a router to spoil what it sends over a link. False: not yet, there is no such link.
  [[nodiscard]] bool spoil(const std::string& host, const std::string& peer,
                           const Quality& quality) const;
  // Is the host's link to that peer up?
  [[nodiscard]] bool is_linked(const std::string& host, const std::string& peer) const;

 private:
  // Nothing when it does not answer, or says no.
  [[nodiscard]] std::optional<json::object> ask(const std::string& host,
                                                const json::object& question) const;

  const Context& context_;
  const Plan& plan_;
};

}  // namespace timsctl::sim

#include "tools/timsctl/sim/routers.h"

#include <fmt/format.h>

#include "tools/timsctl/failure.h"
#include "tools/timsctl/sim/rules.h"

namespace timsctl::sim {

namespace {

using namespace std::chrono_literals;

constexpr tims::Duration kPatience = 500ms;

}  // namespace

std::optional<json::object> Routers::ask(const std::string& host,
                                         const json::object& question) const {
  const PlannedHost* const planned = plan_.find_host(host);
  if (planned == nullptr) return std::nullopt;
  try {
    const auto connection = connect_local({planned->socket()}, {}, kPatience, [](const auto&) {});
    AdminClient admin(*connection, context_.signals, kPatience);
    return admin.ask(question);
  } catch (const Failure& failure) {
    context_.out.detail(fmt::format("{}: {}", host, failure.message));
    return std::nullopt;
  }
}

bool Routers::spoil(const std::string& host, const std::string& peer,
                    const Quality& quality) const {
  return ask(host, router_faults(peer, quality)).has_value();
}

bool Routers::is_linked(const std::string& host, const std::string& peer) const {
  const auto answer = ask(host, {{"ask", "links"}, {"link", peer}});
  if (!answer) return false;
  for (const json::value& link : items_of(*answer))
    if (text_at(link.as_object(), "state") == "up") return true;
  return false;
}

}  // namespace timsctl::sim

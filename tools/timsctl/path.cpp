#include "tools/timsctl/path.h"

#include <algorithm>

#include "tools/timsctl/failure.h"
#include "tools/timsctl/fleet.h"

namespace timsctl {
namespace {

bool has_it(const Step& step) {
  const std::string verdict = text_at(step.answer, "verdict");
  return verdict == "deliver" || verdict == "self";
}

}  // namespace

std::optional<Step> find_owner(const AdminClient& first, tims::Address mailbox) {
  const json::object fleet = walk_fleet(first);
  for (const json::value& value : items_of(fleet)) {
    const json::object& item = value.as_object();
    const auto router = router_address(item);
    if (!router || text_at(item, "state") != "up") continue;
    Step step{.router = router, .name = text_at(item, "name"), .answer = {}};
    try {
      step.answer = first.at(router).ask({{"ask", "route"}, {"to", mailbox.to_hex()}});
    } catch (const Failure&) {
      continue;  // gone meanwhile
    }
    if (has_it(step)) return step;
  }
  return std::nullopt;
}

Path find_path(const AdminClient& first, std::optional<tims::Address> from, tims::Address to,
               std::int8_t type) {
  constexpr std::size_t kStepsMax = 20;
  json::object question{{"ask", "route"}, {"to", to.to_hex()}, {"type", type}};
  if (from) question["from"] = from->to_hex();
  Path path;
  std::optional<tims::Address> at = first.router();
  while (path.steps.size() < kStepsMax) {
    AdminClient router = first.at(at);
    Step step{.router = at, .name = {}, .answer = {}};
    try {
      step.answer = router.ask(question);
    } catch (const Failure& failure) {
      if (path.steps.empty()) throw;
      path.failure = failure.message;
      return path;
    }
    step.name = text_at(step.answer, "router");
    const bool forwards = text_at(step.answer, "verdict") == "forward";
    const auto next = tims::Address::parse(text_at(step.answer, "next_router.raw"));
    path.steps.push_back(std::move(step));
    path.reached = has_it(path.steps.back());
    if (!forwards || !next) return path;
    at = next;
  }
  path.failure = "the routers send it round in a loop";
  return path;
}

}  // namespace timsctl

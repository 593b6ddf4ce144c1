#include "tools/timsctl/path.h"

#include <algorithm>

#include "tools/timsctl/failure.h"

namespace timsctl {

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
    const std::string verdict = text_at(step.answer, "verdict");
    const auto next = tims::Address::parse(text_at(step.answer, "next_router.raw"));
    path.steps.push_back(std::move(step));
    path.reached = verdict == "deliver" || verdict == "self";
    if (verdict != "forward" || !next) return path;
    at = next;
  }
  path.failure = "the routers send it round in a loop";
  return path;
}

}  // namespace timsctl

#include "tools/timsctl/message_path.h"

#include <algorithm>
#include <array>
#include <chrono>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "tools/cli/output.h"
#include "tools/timsctl/message.h"

namespace timsctl {
namespace {

// Only the reason of an error depends on it.
constexpr tims::Duration kAnswersWithin = std::chrono::seconds(1);

bool has_it(const Step& step) {
  const std::string verdict = text_at(step.answer, "verdict");
  return verdict == "deliver" || verdict == "self";
}

}  // namespace

std::optional<Step> find_owner(const AdminClient& first, tims::Address mailbox) {
  const json::object fleet = walk_fleet(first);
  for (const json::object& item : objects(items_of(fleet))) {
    const auto router = router_address(item);
    if (!router || text_at(item, "state") != "up") continue;
    Step step{.router = router, .name = text_at(item, "name"), .answer = {}};
    try {
      step.answer = first.at(router).ask({{"ask", "route"}, {"to", mailbox.to_hex()}});
    } catch (const Failure&) {
      continue;  // the router has disconnected
    }
    if (has_it(step)) return step;
  }
  return std::nullopt;
}

MessageKind MessageKind::of(const Options& options, tims::Address to,
                            const tims::AddressWidths& widths) {
  constexpr std::array<std::string_view, 4> kRights{"look", "change", "agree", "login"};
  if (std::ranges::find(kRights, options.type) != kRights.end())
    return {.type = tims::type::kAdminRequest, .right = options.type};
  return {.type = type_to_assume(options, to, widths)};
}

Path find_path(const AdminClient& first, std::optional<tims::Address> from, tims::Address to,
               const MessageKind& kind) {
  constexpr std::size_t kStepsMax = 20;
  json::object question{{"ask", "route"}, {"to", to.to_hex()}, {"type", kind.type}};
  if (!kind.right.empty()) question["what"] = kind.right;
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
  path.failure = "there is a routing loop";
  return path;
}

std::optional<BrokenLink> broken_link(const AdminClient& first, const Path& path,
                                      tims::Address to) {
  const double system = to.fields(first.widths()).system;
  for (const Step& step : path.steps) {
    const json::object links = first.at(step.router).ask({{"ask", "links"}});
    for (const json::object& link : objects(items_of(links))) {
      const bool theirs = number_at(link, "system") == system && text_at(link, "kind") != "super";
      const bool above = text_at(link, "kind") == "super" && &step == &path.steps.back();
      const std::string state = text_at(link, "state");
      if (state == "up" || (!theirs && !above)) continue;
      const std::string refusal = text_at(link, "refusal");
      return BrokenLink{
          base::printable(fmt::format("the link of {} to {} is {} since {}{}{}", step.name,
                                      text_at(link, "via"), state,
                                      base::human_duration(number_or_zero(link, "since_s")),
                                      refusal.empty() ? "" : ": ", refusal)),
          state == "down"
              ? fmt::format("`timsctl -r {} link up {}`", step.name, text_at(link, "via"))
              : "is that host up, and its network? `timsctl link show` on both sides"};
    }
  }
  return std::nullopt;
}

std::optional<BrokenLink> broken_link_to(Context& context, Connection& connection,
                                         tims::Address to) {
  try {
    const AdminClient admin(connection, context.signals,
                            std::min(kAnswersWithin, context.options.timeout));
    const Path path = find_path(admin, {}, to, {.type = tims::type::kGetStatus});
    if (path.reached) return std::nullopt;
    return broken_link(admin, path, to);
  } catch (const Failure&) {
    return std::nullopt;  // an original router, or one that does not answer
  }
}

Failure with_broken_link(Context& context, Connection& connection, tims::Address to,
                         Failure failure) {
  if (failure.exit != Exit::kNoSuch && failure.exit != Exit::kTimeout) return failure;
  const auto broken = broken_link_to(context, connection, to);
  if (!broken) return failure;
  failure.message += "; " + broken->cause;
  failure.hint = broken->remedy;
  return failure;
}

}  // namespace timsctl

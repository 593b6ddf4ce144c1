// timsctl acl: the rules of a router's policy, what they have met, and what they say.
#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "base/text.h"
#include "tools/cli/admin_client.h"
#include "tools/cli/arguments.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/message.h"
#include "tools/timsctl/message_path.h"

namespace timsctl {
namespace {

constexpr Column kRules[] = {
    {"RULE", "name"},
    {"FROM", "from"},
    {"TO", "to"},
    {"TYPES", "types"},
    {"THEN", "then"},
    {"THIN", "thin"},
    {"PRIORITY", "priority_max"},
    {"RATE/S", "rate_bytes_per_s", Cell::kBytes},
    {"PLACE", "place"},
};

constexpr Column kHits[] = {
    {"RULE", "name"},
    {"THEN", "then"},
    {"MESSAGES", "messages", Cell::kCount},
    {"BYTES", "bytes", Cell::kBytes},
    {"DENIED", "denied", Cell::kCount, false, true},
    {"OVER RATE", "over_rate", Cell::kCount},
    {"LOWERED", "lowered", Cell::kCount},
    {"THINNED", "thinned", Cell::kCount},
    {"PLACE", "place"},
};

constexpr Column kVerdicts[] = {
    {"ROUTER", "router"},     {"WHO", "who"},   {"VERDICT", "verdict"},
    {"PRIORITY", "priority"}, {"RULE", "rule"}, {"PLACE", "place"},
};

constexpr Column kAudit[] = {
    {"TIME", "time"},
    {"KIND", "kind"},
    {"TEXT", "text"},
};

// Messages come from a router on the way as the next one knows it: as a client at a link.
std::string who_is(AdminClient& router, AdminClient& next) {
  const std::string address = text_at(router.ask({{"ask", "status"}}), "address.raw");
  std::string name;
  const json::object links = next.ask({{"ask", "links"}});
  for (const json::object& link : objects(items_of(links)))
    if (text_at(link, "address.raw") == address) name = text_at(link, "name");
  const json::object clients = next.ask({{"ask", "clients"}});
  for (const json::object& client : objects(items_of(clients)))
    if (text_at(client, "port") == "link" && text_at(client, "name") == name)
      return text_at(client, "subject");
  return "port:link";
}

// Asks the routers on the way of a message in turn, until one denies it.
class Trial {
 public:
  Trial(Context& context, const AdminClient& admin) : context_(context), admin_(admin) {}

  Exit run() {
    const Options& options = context_.options;
    const tims::Address to = need_address(options.to, admin_.widths());
    const Path path = find_path(admin_, {}, to, MessageKind::of(options, to, admin_.widths()));
    std::string who = options.from;
    std::optional<AdminClient> before;
    for (const Step& step : path.steps) {
      AdminClient router = admin_.at(step.router);
      if (before) who = who_is(*before, router);
      if (!judge(router, who, to)) break;
      before.emplace(router);
    }
    print();
    return allowed_ ? Exit::kDone : Exit::kNo;
  }

 private:
  bool judge(AdminClient& router, const std::string& who, tims::Address to) {
    const std::string what = context_.options.type.empty() ? "get_status" : context_.options.type;
    json::object verdict = router.ask({{"ask", "verdict"},
                                       {"who", who},
                                       {"to", to.to_hex()},
                                       {"what", what},
                                       {"priority", priority_}});
    verdict["who"] = who;
    priority_ = static_cast<std::int64_t>(number_or_zero(verdict, "priority"));
    allowed_ = text_at(verdict, "verdict") != "deny";
    verdicts_.push_back(std::move(verdict));
    return allowed_;
  }

  void print() {
    if (context_.out.json())
      return context_.out.write(
          json::object{{"schema", "tims/acl_test/1"}, {"allowed", allowed_}, {"items", verdicts_}});
    context_.out.write(render_items(verdicts_, kVerdicts, context_.out.look()));
    context_.out.write(paint(allowed_ ? "allowed" : "denied", allowed_ ? Tone::kGood : Tone::kBad,
                             context_.out.look().colour) +
                       "\n");
  }

  Context& context_;
  AdminClient admin_;
  json::array verdicts_;
  std::int64_t priority_ = context_.options.priority.value_or(0);
  bool allowed_ = false;
};

}  // namespace

Exit acl_show(Context& context) { return show_items(context, {{"ask", "rules"}}, kRules); }
Exit acl_hits(Context& context) { return show_items(context, {{"ask", "rules"}}, kHits); }

Exit acl_test(Context& context) {
  const Options& options = context.options;
  if (options.from.empty() || options.to.empty())
    throw usage_error("acl test needs --from and --to",
                      "timsctl acl test --from user:guest --to 'Chassis(3/0)' --type move");
  const auto connection = context.connect();
  return Trial(context, context.admin(*connection)).run();
}

Exit acl_log(Context& context) {
  const auto ask = [&](AdminClient& admin) {
    json::array all;
    json::object answer;
    for (std::int64_t since = 0;;) {
      answer = admin.ask({{"ask", "events"}, {"audit", true}, {"since", since}});
      json::array& items = item_array(answer);
      if (items.empty()) break;
      since = static_cast<std::int64_t>(number_or_zero(answer, "last"));
      for (json::value& item : items) all.push_back(std::move(item));
    }
    if (const auto count = context.options.count; count && *count < all.size())
      all.erase(all.begin(), all.end() - static_cast<std::ptrdiff_t>(*count));
    answer["items"] = std::move(all);
    return answer;
  };
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  const json::object answer = ask(admin);
  context.out.write(answer,
                    [&] { return render_items(items_of(answer), kAudit, context.out.look()); });
  return Exit::kDone;
}

}  // namespace timsctl

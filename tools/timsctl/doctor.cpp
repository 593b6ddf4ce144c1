// timsctl doctor: looks for what usually goes wrong.
#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"
#include "base/wall_time.h"
#include "os/clock.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/findings.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

namespace {

constexpr std::uint16_t kTcpPort = 2000;

void ask_router(Context& context, Observations& observed) {
  const auto connection = context.connect();
  AdminClient admin = context.admin(*connection);
  observed.status = admin.ask({{"ask", "status"}});
  const auto there = base::parse_rfc3339(text_at(observed.status, "time"));
  if (there)
    observed.clock_difference_s =
        std::chrono::duration<double>(*there - tims::os::wall_now()).count();
  json::object mailboxes = admin.ask({{"ask", "mailboxes"}});
  observed.mailboxes = std::move(items_of(mailboxes));
  json::object clients = admin.ask({{"ask", "clients"}});
  observed.clients = std::move(items_of(clients));
  observed.stats = admin.ask({{"ask", "stats"}});
  json::object links = admin.ask({{"ask", "links"}});
  observed.links = std::move(items_of(links));
}

void find_dead_owners(Observations& observed) {
  for (const json::value& value : observed.mailboxes) {
    const json::object& mailbox = value.as_object();
    const auto pid = static_cast<std::uint32_t>(number_or_zero(mailbox, "owner.pid"));
    if (pid == 0 || is_running(pid)) continue;
    observed.dead_owners.push_back(
        fmt::format("{} of {} (pid {})", text_at(mailbox, "address.name"),
                    base::printable(text_at(mailbox, "owner.name")), pid));
  }
}

void look_at_host(const std::string& path, Observations& observed) {
  observed.socket = socket_file(path);
  if (observed.unreachable)
    observed.tcp_port_owner = port_owner(kTcpPort);
  else
    observed.files = open_files(static_cast<std::uint32_t>(number_or_zero(observed.status, "pid")));
  observed.memory = shared_memory();
  observed.clock_synchronised = clock_is_synchronised();
  observed.receive_buffer_max = number_in("/proc/sys/net/core/rmem_max");
  find_dead_owners(observed);
}

Observations gather(Context& context) {
  Observations observed{.where = to_string(context.host),
                        .local = std::holds_alternative<UnixHost>(context.host),
                        .version = std::string(own_version())};
  try {
    ask_router(context, observed);
  } catch (const Failure& failure) {
    observed.unreachable = failure;
  }
  if (observed.local) look_at_host(std::get<UnixHost>(context.host).path, observed);
  return observed;
}

struct Counts {
  std::size_t warnings = 0;
  std::size_t failures = 0;
};
Counts count(const std::vector<Finding>& findings) {
  const auto of = [&](Level level) {
    return static_cast<std::size_t>(std::ranges::count(findings, level, &Finding::level));
  };
  return {of(Level::kWarning), of(Level::kFailure)};
}

std::string draw(const std::vector<Finding>& findings, const Look& look, bool quiet) {
  std::string text;
  for (const Finding& f : findings) {
    if (quiet && f.level < Level::kWarning) continue;
    const Tone tone = f.level == Level::kOk        ? Tone::kGood
                      : f.level == Level::kInfo    ? Tone::kPlain
                      : f.level == Level::kWarning ? Tone::kWarning
                                                   : Tone::kBad;
    text += fmt::format("{}  {:<20} {}\n",
                        paint(fmt::format("{:<7}", name(f.level)), tone, look.colour), f.id,
                        base::printable(f.text));
    if (!f.hint.empty()) text += fmt::format("{:30}-> {}\n", "", f.hint);
  }
  const Counts n = count(findings);
  return text + fmt::format("{} failure{}, {} warning{}\n", n.failures, n.failures == 1 ? "" : "s",
                            n.warnings, n.warnings == 1 ? "" : "s");
}

json::object to_json(const Observations& observed, const std::vector<Finding>& findings) {
  json::array items;
  for (const Finding& f : findings)
    items.push_back(json::object{{"id", f.id},
                                 {"level", name(f.level)},
                                 {"text", f.text},
                                 {"hint", f.hint.empty() ? json::value() : json::value(f.hint)}});
  const Counts n = count(findings);
  return {{"schema", "tims/doctor/1"},
          {"host", observed.where},
          {"time", base::rfc3339(tims::os::wall_now())},
          {"failures", n.failures},
          {"warnings", n.warnings},
          {"items", std::move(items)}};
}

// One line and the exit status that monitoring programs read.
Exit nagios(Context& context, const Observations& observed, const std::vector<Finding>& findings) {
  const Counts n = count(findings);
  const int level = n.failures > 0 ? 2 : n.warnings > 0 ? 1 : 0;
  const char* word = level == 2 ? "CRITICAL" : level == 1 ? "WARNING" : "OK";
  std::string text = fmt::format("TIMS {}", word);
  const char* separator = " - ";
  for (const Finding& f : findings) {
    if (f.level < Level::kWarning) continue;
    text += fmt::format("{}{}", separator, base::printable(f.text));
    separator = "; ";
  }
  context.out.write(fmt::format(
      "{} | clients={} mailboxes={} drops={}c\n", text, number_or_zero(observed.status, "clients"),
      number_or_zero(observed.status, "mailboxes"), number_or_zero(observed.status, "drops")));
  return static_cast<Exit>(level);
}

constexpr Column kColumns[] = {
    {"CODE", "code"}, {"KIND", "kind"}, {"MEANING", "meaning"}, {"HINT", "hint", As::kText, true}};

json::object to_json(const CatalogueEntry& entry) {
  return {
      {"code", entry.code}, {"kind", entry.kind}, {"meaning", entry.meaning}, {"hint", entry.hint}};
}

}  // namespace

Exit doctor(Context& context) {
  const Observations observed = gather(context);
  const std::vector<Finding> findings = judge(observed);
  if (context.options.style == "nagios") return nagios(context, observed, findings);
  if (context.out.json())
    context.out.write(to_json(observed, findings));
  else
    context.out.write(draw(findings, context.out.look(), context.options.quiet));
  if (observed.unreachable) return observed.unreachable->exit;
  return count(findings).failures > 0 ? Exit::kNo : Exit::kDone;
}

// --- timsctl errors: the catalogue, without a router.

Exit errors(Context& context) {
  json::array items;
  const auto& arguments = context.options.arguments;
  for (const CatalogueEntry& entry : catalogue())
    if (arguments.empty() || arguments.front() == entry.code) items.push_back(to_json(entry));
  if (items.empty())
    throw Failure(Exit::kNoSuch, "no_such_code", fmt::format("no code \"{}\"", arguments.front()),
                  "`timsctl errors` lists all");
  const Look& look = context.out.look();
  if (look.format == Format::kJson) {
    context.out.write(json::object{{"schema", "tims/code/1"}, {"items", std::move(items)}});
  } else if (arguments.empty() || look.format != Format::kTable) {
    context.out.write(render_items({items.data(), items.size()}, kColumns, look));
  } else {
    const CatalogueEntry& entry = *find_in_catalogue(arguments.front());
    context.out.write(fmt::format("{} ({}): {}\n", entry.code, entry.kind, entry.meaning));
    if (!entry.hint.empty()) context.out.write(fmt::format("  -> {}\n", entry.hint));
  }
  return Exit::kDone;
}

}  // namespace timsctl

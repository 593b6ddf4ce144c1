#include "tools/cli/options.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "base/measure.h"
#include "base/text.h"

namespace timsctl {

namespace {

using std::string_view;

[[noreturn]] void refuse(string_view what, string_view text) {
  throw usage_error("\"" + std::string(text) + "\" is not " + std::string(what));
}

template <typename T>
T need(std::optional<T> value, string_view what, string_view text) {
  if (!value) refuse(what, text);
  return *value;
}

tims::Duration duration(string_view text) {
  return need(base::parse_duration(text), "a duration such as 250ms, 2s or 1min", text);
}
// Zero would cause a busy loop.
tims::Duration pause(string_view text) {
  const auto value = duration(text);
  if (value < std::chrono::milliseconds(10)) refuse("a duration of at least 10ms", text);
  return value;
}
std::uint32_t size(string_view text) {
  return need(base::parse_size(text), "a size such as 64, 4KiB or 1MiB", text);
}
std::uint64_t count(string_view text) {
  return need(base::parse_number<std::uint64_t>(text), "a count", text);
}
std::int64_t number_up_to(std::int64_t max, string_view what, string_view text) {
  const auto value = base::parse_number<std::int64_t>(text);
  if (!value || *value < 0 || *value > max) refuse(what, text);
  return *value;
}
double rate(string_view text) {
  double value = 0;
  try {
    value = std::stod(std::string(text));
  } catch (const std::exception&) {
  }
  const bool good = value > 0 && value <= 100'000;  // NaN is not
  if (!good) refuse("a rate in Hz, above 0 and up to 100000", text);
  return value;
}

constexpr std::array<string_view, 6> kForms = {"table", "wide", "plain", "json", "csv", "name"};

Format format(string_view text) {
  const auto at = std::ranges::find(kForms, text);
  if (at == kForms.end()) refuse("one of table, wide, plain, json, csv, name", text);
  return static_cast<Format>(at - kForms.begin());
}

std::string one_of(string_view text, std::initializer_list<string_view> known) {
  if (std::ranges::find(known, text) != known.end()) return std::string(text);
  std::string names;
  for (const string_view name : known) names.append(names.empty() ? "" : ", ").append(name);
  refuse("one of " + names, text);
}

std::string router_name(string_view text) {
  const bool is_place = text.find(':') != string_view::npos && text.find('(') == string_view::npos;
  if (is_place) refuse("the name or address of a router; use -H for HOST:PORT and unix:PATH", text);
  return std::string(text);
}

constexpr OptionRow kOptions[] = {
    {"host", 'H', "HOST",
     "use the router at HOST[:PORT] or unix:PATH (default: $TIMS_HOST, else this host)",
     [](Options& o, string_view v) { o.host = v; }},
    {"router", 'r', "NAME",
     "ask another router of the fleet (name or address) through the router of -H",
     [](Options& o, string_view v) { o.router = router_name(v); }},
    {"json", 'j', "", "print JSON; one object per line if output is repeated",
     [](Options& o, string_view) { o.format = Format::kJson; }},
    {"json-lines", 0, "", "the same as --json",
     [](Options& o, string_view) { o.format = Format::kJson; }},
    {"output", 'o', "FORM", "output format: table, wide, plain, json, csv or name",
     [](Options& o, string_view v) { o.format = format(v); }},
    {"watch", 'w', "[2]", "repeat every 2 s, or at this interval in seconds",
     [](Options& o, string_view v) { o.watch = pause(v); }},
    {"once", 0, "", "the same as -n 1", [](Options& o, string_view) { o.count = 1; }},
    {"count", 'n', "N",
     "stop after N repetitions, messages or events; of log: the newest N messages",
     [](Options& o, string_view v) {
       o.count = count(v);
       if (o.count == 0) refuse("a count of at least 1", v);
     }},
    {"for", 0, "DUR", "stop after this time",
     [](Options& o, string_view v) { o.run_for = duration(v); }},
    {"timeout", 0, "DUR", "wait so long for an answer (default 2s; for ON 5s)",
     [](Options& o, string_view v) {
       o.timeout = pause(v);
       o.has_timeout = true;
     }},
    {"sort", 0, "COL", "sort the rows by this column; numbers in descending order",
     [](Options& o, string_view v) { o.sort = v; }},
    {"quiet", 'q', "", "print only the result, no notes",
     [](Options& o, string_view) { o.quiet = true; }},
    {"verbose", 'v', "", "print more notes", [](Options& o, string_view) { o.verbose = true; }},
    {"no-color", 0, "", "do not use colours (also $NO_COLOR)",
     [](Options& o, string_view) { o.no_color = true; }},
    {"utc", 0, "", "print times in UTC", [](Options& o, string_view) { o.utc = true; }},
    {"yes", 'y', "", "do not ask for confirmation before something moves",
     [](Options& o, string_view) { o.yes = true; }},
    {"interval", 'i', "DUR", "interval between requests or reports (default 1s)",
     [](Options& o, string_view v) { o.interval = pause(v); }},
    {"from", 0, "ADDR", "assume this sender", [](Options& o, string_view v) { o.from = v; }},
    {"to", 0, "ADDR", "assume this destination", [](Options& o, string_view v) { o.to = v; }},
    {"type", 0, "T", "message type: a number or a name such as get_status",
     [](Options& o, string_view v) { o.type = v; }},
    {"listen", 0, "ADDR", "register ADDR and print the messages that arrive there",
     [](Options& o, string_view v) { o.listen = v; }},
    {"hex", 0, "DIGITS", "message body in hex digits",
     [](Options& o, string_view v) { o.hex = v; }},
    {"file", 'f', "FILE", "read messages written by `msg echo`, or a body, from FILE; - is stdin",
     [](Options& o, string_view v) { o.file = v; }},
    {"raw", 0, "", "echo: print bytes (input of `msg pub -f`); pub: send the file as a body",
     [](Options& o, string_view) { o.raw = true; }},
    {"fields", 0, "", "print one field per line", [](Options& o, string_view) { o.fields = true; }},
    {"si", 0, "", "use SI units: m, s (angles remain clockwise)",
     [](Options& o, string_view) { o.si = true; }},
    {"newest", 0, "", "show what the router has kept, with its age; asks no component",
     [](Options& o, string_view) { o.newest = true; }},
    {"filter", 0, "COND",
     "only messages that match: 'vx>100', 'type_name=move,points[].distance<300'",
     [](Options& o, string_view v) { o.filter = v; }},
    {"dry-run", 0, "", "only print what would be changed",
     [](Options& o, string_view) { o.dry_run = true; }},
    {"no-wait", 0, "", "do not wait for the answer to a command",
     [](Options& o, string_view) { o.no_wait = true; }},
    {"rate", 0, "HZ", "send repeatedly at this rate [Hz]",
     [](Options& o, string_view v) { o.rate_hz = rate(v); }},
    {"priority", 0, "P", "message priority, 0 to 255; higher is more urgent",
     [](Options& o, string_view v) {
       o.priority = static_cast<std::uint8_t>(number_up_to(255, "a priority from 0 to 255", v));
     }},
    {"size", 's', "BYTES", "bytes to add to each request to the router",
     [](Options& o, string_view v) { o.size_bytes = size(v); }},
    {"body-max", 0, "SIZE", "largest body that can be received (default 4MiB)",
     [](Options& o, string_view v) { o.body_max_bytes = size(v); }},
    {"period", 0, "DUR", "request one message per DUR (default: every message)",
     [](Options& o, string_view v) { o.period = duration(v); }},
    {"by", 0, "WHAT", "group the rows by reason, port or class",
     [](Options& o, string_view v) {
       o.by = one_of(v, {"reason", "port", "class"});
     }},
    {"all-routers", 'a', "", "include every router of the fleet",
     [](Options& o, string_view) { o.all_routers = true; }},
    {"hops", 0, "", "include every router on the path",
     [](Options& o, string_view) { o.hops = true; }},
    {"origin", 0, "", "also print the source of each value",
     [](Options& o, string_view) { o.origin = true; }},
    {"format", 0, "FORM", "report format: text or nagios",
     [](Options& o, string_view v) {
       o.style = one_of(v, {"text", "nagios"});
     }},
    {"fleet", 0, "NAME", "name of the fleet; required if several run",
     [](Options& o, string_view v) { o.fleet = v; }},
    {"link", 0, "NAME", "link of the router of -H, by the name of the other router; or all",
     [](Options& o, string_view v) { o.link = v; }},
    {"system", 0, "N", "number of the robot, 0 to 65535, instead of the one in the file",
     [](Options& o, string_view v) {
       o.system = number_up_to(65535, "a system from 0 to 65535", v);
     }},
    {"on", 0, "HOST", "up: start only the components for HOST, on this host; deploy: only HOST",
     [](Options& o, string_view v) { o.on = v; }},
    {"world", 0, "ADDR", "address of the World; required if there are several",
     [](Options& o, string_view v) { o.world = v; }},
    {"wait", 0, "[30s]", "retry until the condition holds, at most 30 s or this duration",
     [](Options& o, string_view v) { o.wait = duration(v); }},
    {"component", 'c', "GLOB", "only log messages of these components",
     [](Options& o, string_view v) { o.component = v; }},
    {"level", 'l', "LEVEL", "least important level to show: print, error, warning, info or detail",
     [](Options& o, string_view v) {
       o.level = need(rack::gdos::level_of(v), "one of print, error, warning, info, detail", v);
     }},
    {"since", 'S', "TIME", "not earlier than: 10min (ago), 03:15, 2026-11-22, '2026-11-22 03:15'",
     [](Options& o, string_view v) { o.since = v; }},
    {"until", 'U', "TIME", "not later than this", [](Options& o, string_view v) { o.until = v; }},
    {"directory", 'D', "DIR", "folder of the files of gdos-log",
     [](Options& o, string_view v) { o.directory = v; }},
    {"robot", 0, "ROBOT",
     "robot to use: its system number or the name of its router; required if there are several",
     [](Options& o, string_view v) { o.robot = v; }},
    {"gps", 0, "", "X and Y are degrees north and east",
     [](Options& o, string_view) { o.gps = true; }},
    {"patience", 0, "DUR", "longest standstill before the drive has failed (default 30s)",
     [](Options& o, string_view v) { o.patience = pause(v); }},
    {"anyway", 0, "", "also send a robot that is not sure where it is",
     [](Options& o, string_view) { o.anyway = true; }},
    {"plot", 0, "FILE", "also draw a picture, .svg or .png",
     [](Options& o, string_view v) { o.plot = v; }},
    {"objects", 0, "OBJRECOG",
     "draw boxes around the objects that this component has recognised in the picture",
     [](Options& o, string_view v) { o.objects = v; }},
    {"why", 0, "TEXT", "the reason of the change, for its history",
     [](Options& o, string_view v) { o.why = v; }},
    {"window", 0, "DUR",
     "go back unless confirmed in this time (default 90s); hosts allow 30s to 10min unless their "
     "tims-agent has a --least-window",
     [](Options& o, string_view v) {
       o.window = duration(v);
       if (o.window < std::chrono::seconds(3) || o.window > std::chrono::minutes(10))
         refuse("a time from 3s to 10min", v);
     }},
    {"generation", 0, "N", "the files of this generation, as in `config history`",
     [](Options& o, string_view v) { o.generation = count(v); }},
    {"keys", 0, "DIR", "folder of keys (default: $TIMS_KEYS, else /etc/tims/keys)",
     [](Options& o, string_view v) { o.keys = v; }},
    {"role", 0, "ROLE", "role of the member: subsystem, system, top or user",
     [](Options& o, string_view v) {
       o.role = one_of(v, {"subsystem", "system", "top", "user"});
     }},
    {"id", 0, "N", "router.id of the member, 0 to 65535 (default 1)",
     [](Options& o, string_view v) { o.id = number_up_to(65535, "an id from 0 to 65535", v); }},
    {"name", 0, "NAME", "name of the member (default: robotN, robotN-ID, base)",
     [](Options& o, string_view v) { o.name = v; }},
    {"rights", 0, "LIST", "what a user may do: look, drive, configure (default: look)",
     [](Options& o, string_view v) { o.rights = v; }},
    {"address", 0, "LIST", "addresses or names by which others reach this host (default: its own)",
     [](Options& o, string_view v) { o.address = v; }},
    {"bearer", 0, "", "for a program: print the line that it sends with each request",
     [](Options& o, string_view) { o.bearer = true; }},
    {"finish", 0, "", "believe the old root no longer",
     [](Options& o, string_view) { o.finish = true; }},
    {"force", 0, "",
     "also if members would have to join again, this host leaves its fleet (import), or something "
     "is lost (deploy)",
     [](Options& o, string_view) { o.force = true; }},
    {"undo", 0, "", "back to what was there before the last deployment",
     [](Options& o, string_view) { o.undo = true; }},
    {"until-idle", 0, "", "end when no token is open any more",
     [](Options& o, string_view) { o.until_idle = true; }},
    {"detach", 0, "", "continue in the background after the start",
     [](Options& o, string_view) { o.detach = true; }},
    {"insecure", 0, "", "without keys: every program in the fleet's networks may do everything",
     [](Options& o, string_view) { o.insecure = true; }},
};

constexpr std::string_view kRobot = "timsctl-robot";
constexpr std::string_view kDeploy = "timsctl-deploy";
constexpr std::string_view kSim = "timsctl-sim";

// The last verb of timsctl-robot implements `timsctl component param save` and is not listed.
constexpr Verb kProgramVerbs[] = {
    {"up", "", "FILE", 1, 1, "system on for detach", true,
     "Start the components of a robot at the router of -H, pass on their output, and restart those "
     "that crash. Runs until Ctrl-C, then stops them. FILE - is stdin. Exit status 1: a component "
     "ended and could not be restarted.",
     "timsctl up deploy/robots/sim.toml --system 1", nullptr, kTexts, kRobot},
    {"down", "", "[NAME]", 0, 1, "", false, "Stop a robot that `up` has started on this host.",
     "timsctl down sim-1", nullptr, kTexts, kRobot},
    {"robot", "show", "", 0, 0, "", false,
     "List robots that `up` has started on this host: their programs and states.", "timsctl robot",
     nullptr, kRows, kRobot},
    {"param", "save", "ADDR [NAME]", 1, 2, "wait dry-run", false,
     "Write the parameters of a component that were set since `up` started it into the robot file.",
     "", nullptr, kRows, kRobot},

    {"deploy", "", "FILE", 1, 1, "on system dry-run undo force yes", false,
     "Bring a robot to its hosts, over ssh: packages, configuration and keys, as its file says in "
     "[deploy] and [host.NAME]. No host is changed before all are prepared; each comes up within "
     "30 s (--timeout) and `doctor` finds nothing new, or it goes back. After an interruption, "
     "call "
     "it again. --undo: what was there before the last deployment. --force: also overwrite files "
     "that were changed there, and replace packages that nobody has to go back to. At a terminal "
     "it "
     "asks before hosts change, also with --json, unless -y is given. Exit status 1: a host was "
     "not "
     "changed, or went back; 6: it is not known.",
     "timsctl deploy scout.toml --dry-run", nullptr, kTexts, kDeploy},

    {"sim", "up", "FILE", 1, 1, "fleet for detach insecure", true,
     "Start a fleet on this machine: network namespaces, a router with keys in each, components, "
     "lines with faults. Runs until Ctrl-C, then removes everything. Exit status 1: a program "
     "ended unexpectedly. Needs root.",
     "timsctl sim up deploy/fleets/demo.toml", nullptr, kTexts, kSim},
    {"sim", "down", "[NAME]", 0, 1, "fleet", false,
     "Stop a fleet, or remove the remains of a crashed one; without NAME: all fleets.",
     "timsctl sim down demo", nullptr, kTexts, kSim},
    {"sim", "show", "[NAME]", 0, 1, "", false,
     "Show fleets on this machine: hosts, addresses, router sockets, lines, programs.",
     "timsctl sim show", nullptr, kTexts, kSim},
    {"sim", "fault", "LINE PROFILE|KEY=VALUE|cut|heal...", 1, 20, "fleet link", false,
     "Change a line between two hosts. Profiles: cable, wifi, corridor, lte, blackout and those of "
     "the fleet file. Keys: loss, duplicate, reorder, delay, jitter, rate, and direction (up: "
     "towards the base, down). cut: interrupt the line; heal: restore the state of the fleet file. "
     "Omitted keys are faultless. With --link NAME instead of LINE: faults that the router of -H "
     "(of any fleet, with sim.faults = true) applies to its own datagrams to router NAME (all: to "
     "all routers); there, cut and direction are not available: ask the other router for the other "
     "direction.",
     "timsctl sim fault robot1-base loss=10% delay=20ms direction=up", nullptr, kTexts, kSim},
    {"sim", "kill", "HOST [router|PROGRAM]", 1, 2, "fleet", false,
     "Kill everything on a host at once, like a power failure; or only its router, or the programs "
     "with PROGRAM in their command.",
     "timsctl sim kill robot1-main", nullptr, kTexts, kSim},
    {"sim", "start", "HOST", 1, 1, "fleet", false,
     "Start the programs of a host that are not running.", "timsctl sim start robot1-main", nullptr,
     kTexts, kSim},
    {"sim", "exec", "HOST COMMAND...", 2, 1000, "fleet", false,
     "Run a command on a host, with $TIMS_ROUTER set. Options after COMMAND belong to the command.",
     "timsctl sim exec robot1-main timsctl route show -j", nullptr, kTexts, kSim},
};

}  // namespace

std::span<const Verb> program_verbs() { return kProgramVerbs; }

std::span<const OptionRow> option_table() { return kOptions; }

string_view form_name(Format format) { return kForms[static_cast<std::size_t>(format)]; }

const OptionRow* find_option(string_view name) {
  const auto* const row = std::ranges::find(kOptions, name, &OptionRow::name);
  return row == std::end(kOptions) ? nullptr : row;
}

void OptionRow::apply(Options& options, string_view text) const {
  try {
    set(options, text);
  } catch (const Failure& failure) {
    throw usage_error(fmt::format("--{}: {}", name, failure.message));
  }
}

std::string Verb::short_name() const { return std::string(verb.empty() ? noun : verb); }

std::string Verb::name() const {
  return verb.empty() ? std::string(noun) : std::string(noun) + " " + std::string(verb);
}

}  // namespace timsctl

#include "router/config/options.h"

#include <algorithm>
#include <array>

#include <fmt/core.h>

namespace tims::config {
namespace {

constexpr std::int64_t kKi = 1LL << 10;
constexpr std::int64_t kGi = 1LL << 30;
constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kHour = 3'600'000 * kMs;
constexpr std::int64_t kSocketPathMax = 107;  // sockaddr_un, with its zero

// How a member of Config is kept in a Value, and back.
template <Kind kind, typename T>
Value to_value(const T& member) {
  if constexpr (kind == Kind::kSize) return Bytes{std::int64_t{member}};
  if constexpr (kind == Kind::kNumber) return std::int64_t{member};
  return member;
}

template <Kind kind, typename T>
void from_value(T& member, const Value& value) {
  if constexpr (kind == Kind::kSize)
    member = static_cast<T>(std::get<Bytes>(value).count);
  else if constexpr (kind == Kind::kNumber)
    member = static_cast<T>(std::get<std::int64_t>(value));
  else
    member = std::get<T>(value);
}

// A row: the way to the value, then what is said about it.
template <Kind kind, auto table, auto member>
constexpr Option row(Spec spec) {
  spec.kind = kind;
  return {spec, [](const Config& c) { return to_value<kind>(c.*table.*member); },
          [](Config& c, const Value& value) { from_value<kind>(c.*table.*member, value); }};
}

constexpr std::array kOptions{
    row<Kind::kText, &Config::router, &Config::Router::name>(
        {.key = "router.name",
         .range = {1, 64},
         .reload = Reload::kRestart,
         .help = "Name of this router, for people: it stands in logs, refusals and metrics.",
         .default_note = "the host's name",
         .sample = R"("${HOSTNAME}")"}),
    row<Kind::kNumber, &Config::router, &Config::Router::system>(
        {.key = "router.system",
         .range = {0, 255},
         .reload = Reload::kRestart,
         .help = "System (robot) this router belongs to: the first field of its address "
                 "Tims(system/id)."}),
    row<Kind::kNumber, &Config::router, &Config::Router::id>(
        {.key = "router.id",
         .range = {0, 255},
         .reload = Reload::kRestart,
         .help = "Number of this router within its system; no two routers of a system have "
                 "the same."}),

    row<Kind::kText, &Config::unix, &Config::Unix::path>(
        {.key = "unix.path",
         .range = {1, kSocketPathMax},
         .reload = Reload::kRestart,
         .help = "Socket for the components of this host.",
         .default_note = "/run/tims/router.sock for root, else "
                         "$XDG_RUNTIME_DIR/tims/router.sock, else /tmp/tims-UID/router.sock",
         .sample = R"("/run/tims/router.sock")"}),
    row<Kind::kFlag, &Config::unix, &Config::Unix::everybody>(
        {.key = "unix.everybody",
         .reload = Reload::kRestart,
         .help = "Lets every user of this host connect components; otherwise the user the router "
                 "runs as, and the members of its group."}),

    row<Kind::kEndpoint, &Config::tcp, &Config::Tcp::listen>(
        {.key = "tcp.listen",
         .reload = Reload::kRestart,
         .help = "Where original RACK programs and remote clients connect; \"off\" for "
                 "nowhere, port 0 for any free one. Beyond loopback it needs "
                 "security.insecure."}),
    row<Kind::kFlag, &Config::tcp, &Config::Tcp::compat_delete>(
        {.key = "tcp.compat_delete",
         .reload = Reload::kYes,
         .help = "Lets any TCP client delete any mailbox, as the original router did; "
                 "otherwise only the client that registered it."}),
    row<Kind::kSize, &Config::tcp, &Config::Tcp::queue_bytes>(
        {.key = "tcp.queue",
         .range = {64 * kKi, kGi},
         .reload = Reload::kYes,
         .help = "What may wait for one slow TCP client before messages are dropped and "
                 "counted, the least important first."}),

    row<Kind::kEndpoint, &Config::http, &Config::Http::listen>(
        {.key = "http.listen",
         .reload = Reload::kRestart,
         .help = "Where WebSocket clients connect, and /metrics and /healthz are served; "
                 "\"off\" for nowhere. Beyond loopback it needs security.insecure."}),

    row<Kind::kSize, &Config::message, &Config::Message::bytes_max>(
        {.key = "message.max",
         .range = {64 * kKi, kGi},
         .reload = Reload::kRestart,
         .help = "Largest message, its 16-byte header included. The original's is 262144B; "
                 "below 64KiB ordinary laser scans would not fit."}),

    row<Kind::kDuration, &Config::lifesign, &Config::Lifesign::interval>(
        {.key = "lifesign.interval",
         .range = {100 * kMs, kHour},
         .reload = Reload::kYes,
         .help =
             "How often a TCP client is asked whether it still lives; one that has not answered "
             "when the next is due is disconnected. Original Java clients leave by themselves "
             "when they hear nothing for 10s."}),

    row<Kind::kNumber, &Config::limits, &Config::Limits::clients>(
        {.key = "limits.clients",
         .range = {1, 16384},
         .reload = Reload::kYes,
         .help = "Clients connected at the same time, over all ports."}),
    row<Kind::kNumber, &Config::limits, &Config::Limits::mailboxes_per_client>(
        {.key = "limits.mailboxes_per_client",
         .range = {1, 1048576},
         .reload = Reload::kYes,
         .help = "Mailboxes that one client may have registered."}),

    row<Kind::kLogLevel, &Config::log, &Config::Log::level>(
        {.key = "log.level",
         .reload = Reload::kYes,
         .help = "What is logged: this and everything more serious."}),

    row<Kind::kFlag, &Config::security, &Config::Security::insecure>(
        {.key = "security.insecure",
         .reload = Reload::kRestart,
         .help = "Allows listening beyond loopback although this version has no keys: "
                 "everybody who reaches the port can command the robot. Only for networks "
                 "where every machine is trusted."}),
};

constexpr std::string_view kSampleTop =
    "# Configuration of tims-router: every key with its default, switched off by a '#'.\n"
    "# Sizes (B, KiB, MiB, GiB) and durations (ms, s, min, h) carry units. ${NAME} in a text is\n"
    "# the environment variable. An unknown key is an error. tims-router --help says the same.\n";

std::string default_text(const Option& option) {
  if (!option.default_note.empty()) return std::string(option.default_note);
  return to_toml(option.get(Config{}));
}

std::string sample_value(const Option& option) {
  return option.sample.empty() ? default_text(option) : std::string(option.sample);
}

// `text` in lines of at most 98 columns, each behind `margin`.
std::string wrapped(std::string_view text, std::string_view margin) {
  constexpr std::size_t kWidth = 98;
  std::string out;
  std::string line(margin);
  bool empty = true;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    if (!empty && line.size() + 1 + word.size() > kWidth) {
      out += line + '\n';
      line = margin;
      empty = true;
    }
    line += fmt::format("{}{}", empty ? "" : " ", word);
    empty = false;
    text.remove_prefix(std::min(text.size(), word.size() + 1));
  }
  return out + line + '\n';
}

std::string full_help(const Option& option) {
  const bool restart = option.reload == Reload::kRestart;
  return fmt::format("{}{}", option.help, restart ? " Changes need a restart." : "");
}

std::string limits_text(const Option& option) {
  const std::string range = range_text(option.kind, option.range);
  return fmt::format("{}{}{}", kind_name(option.kind), range.empty() ? "" : ", ", range);
}

}  // namespace

std::span<const Option> options() { return kOptions; }

const Option* find_option(std::string_view key) {
  const auto found = std::ranges::find(kOptions, key, &Option::key);
  return found == kOptions.end() ? nullptr : &*found;
}

std::string options_help() {
  std::string out;
  for (const Option& option : kOptions) {
    out += fmt::format("  {}  ({}; default {})\n{}", option.key, limits_text(option),
                       default_text(option), wrapped(full_help(option), "      "));
  }
  return out;
}

std::string sample_file() {
  std::string out(kSampleTop);
  std::string_view table;
  for (const Option& option : kOptions) {
    if (option.table() != table) {
      table = option.table();
      out += fmt::format("\n[{}]\n", table);
    }
    out += wrapped(fmt::format("{} ({})", full_help(option), limits_text(option)), "# ");
    if (!option.default_note.empty())
      out += wrapped(fmt::format("Default: {}", option.default_note), "# ");
    out += fmt::format("#{} = {}\n", option.name(), sample_value(option));
  }
  return out;
}

}  // namespace tims::config

// tims-agent: keeps the configuration files of this host, and answers questions about them
// (PROTOCOL.md) beside the router.
#include <csignal>
#include <cstdio>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "base/measure.h"
#include "os/clock.h"
#include "os/environment.h"
#include "os/service_manager.h"
#include "tims/message.h"
#include "tools/cli/admin_client.h"
#include "tools/cli/program.h"
#include "tools/configuration/agent.h"

namespace timsctl::configuration {
namespace {

using namespace std::chrono_literals;

constexpr tims::Duration kRouterAnswers = 5s;
constexpr tims::Duration kPause = 500ms;    // until the next attempt to reach the router
constexpr tims::Duration kLookAgain = 10s;  // whether the router has another address
constexpr std::uint32_t kSlots = 64;
constexpr std::uint8_t kPriority = 10;

constexpr std::string_view kHelp =
    "tims-agent: keep the configuration files of this host, and answer questions about them.\n"
    "\n"
    "Usage: tims-agent [OPTIONS]\n"
    "\n"
    "It reads and replaces router.toml, router.d/NAME.toml and robots/NAME.toml in one folder, on\n"
    "request of `timsctl config` and of the console, and goes back to the files of before unless "
    "a\n"
    "change is confirmed in time. It talks to the router of this host ($TIMS_ROUTER) and needs\n"
    "the rights to signal it.\n"
    "\n"
    "  --folder=DIR     the configuration files (default: /etc/tims)\n"
    "  --state=DIR      where it keeps its record and the last 20 generations of the files\n"
    "                   (default: $STATE_DIRECTORY, else /var/lib/tims-agent)\n"
    "  --least-window=TIME\n"
    "                   the shortest time that may be asked for until a change goes back, from 3s "
    "to\n"
    "                   90s (default: 30s): programs have to be restarted, and people to look\n"
    "  --help           show this\n"
    "  --version        show the version\n";

struct Settings {
  std::string folder = "/etc/tims";
  std::string state = "/var/lib/tims-agent";
  tims::Duration least_window = kLeastWindow;
};

void log(const std::string& text) { fmt::print(stderr, "tims-agent: {}\n", base::printable(text)); }

std::string router_text(const Message& message) {
  return {reinterpret_cast<const char*>(message.body.data()), message.body.size()};
}

// One connection to the router, until it has another address.
class Session {
 public:
  Session(Agent& agent, const UnixHost& router, const Signals& signals)
      : agent_(agent), router_(router), signals_(signals) {
    identify();
    connection_ = connect_local(
        router_, {.address = mailbox_.to_hex(), .slots = kSlots, .body_max = kQuestionMax},
        kRouterAnswers, [](const std::string& event) { log(event); });
    log("answers as " + mailbox_.to_string(connection_->widths()));
  }

  void run() {
    tims::Time look_again = tims::os::now() + kLookAgain;
    std::uint64_t losses = connection_->losses();
    while (true) {
      const tims::Time deadline = std::min(look_again, agent_.next_timeout());
      if (const auto message = receive(*connection_, signals_, deadline)) take(*message);
      agent_.go_on(tims::os::now());
      ask_peers();
      const bool was_lost = std::exchange(losses, connection_->losses()) != losses;
      if (!was_lost && tims::os::now() < look_again) continue;
      look_again = tims::os::now() + kLookAgain;
      if (has_moved()) return;
    }
  }

 private:
  // Reads the router's address; the mailbox of the agent is beside it.
  void identify() {
    const auto connection = connect_local(router_, {}, kRouterAnswers, [](const std::string&) {});
    const json::object status =
        AdminClient(*connection, signals_, kRouterAnswers).ask({{"ask", "status"}});
    const auto address = tims::Address::parse(text_at(status, "address.raw"));
    if (!address) throw Failure(Exit::kVersion, "version", "the router does not state its address");
    mailbox_ = tims::Address(address->raw() + 1);
    json::object shown = status.at("address").as_object();
    agent_.set_router({.name = text_at(status, "name"),
                       .address = std::move(shown),
                       .widths = text_at(status, "widths")});
  }

  bool has_moved() {
    const tims::Address before = mailbox_;
    try {
      identify();
    } catch (const Failure&) {
      return false;  // it is being restarted
    }
    return mailbox_ != before;
  }

  void take(const Message& message) {
    const tims::Time now = tims::os::now();
    const std::string from = message.header.src.to_hex();
    if (message.header.type == tims::type::kAdminReply)
      return agent_.take_answer(now, router_text(message), from);
    if (message.header.type != tims::type::kAdminRequest) return;
    const std::string answer = agent_.answer(now, router_text(message), from);
    send({.dest = message.header.src,
          .type = tims::type::kAdminReply,
          .priority = message.header.priority,
          .seq_nr = message.header.seq_nr},
         answer);
  }

  void ask_peers() {
    for (const Agent::Peer& peer : agent_.questions_to_peers(tims::os::now()))
      if (const auto address = tims::Address::parse(peer.agent))
        send({.dest = *address, .type = tims::type::kAdminRequest, .priority = kPriority},
             peer.question);
  }

  // Who cannot be reached asks again.
  void send(const tims::Envelope& envelope, const std::string& body) {
    (void)connection_->send(envelope, std::as_bytes(std::span(body)));
  }

  Agent& agent_;
  const UnixHost& router_;
  const Signals& signals_;
  tims::Address mailbox_{};
  std::unique_ptr<Connection> connection_;
};

// The agent goes back in time also while there is no router.
void serve(Agent& agent, const UnixHost& router, const Signals& signals) {
  std::string told;
  while (true) {
    try {
      Session session(agent, router, signals);
      told.clear();
      session.run();
    } catch (const Failure& failure) {
      if (std::exchange(told, failure.message) != failure.message) log(failure.message);
    }
    signals.sleep_until(std::min(tims::os::now() + kPause, agent.next_timeout()));
    agent.go_on(tims::os::now());
  }
}

tims::Duration window_of(std::string_view text) {
  const auto window = base::parse_duration(text);
  if (!window || *window < kWindowMin || *window > kWindow)
    throw usage_error(fmt::format("--least-window={}: it must be from {} to {}", text,
                                  base::human_duration(base::seconds(kWindowMin)),
                                  base::human_duration(base::seconds(kWindow))));
  return *window;
}

std::optional<Settings> settings_of(int argc, char** argv) {
  Settings settings;
  if (const std::string state = tims::os::environment("STATE_DIRECTORY"); !state.empty())
    settings.state = state;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    constexpr std::string_view kFolder = "--folder=";
    constexpr std::string_view kState = "--state=";
    constexpr std::string_view kLeast = "--least-window=";
    if (argument.starts_with(kFolder))
      settings.folder = argument.substr(kFolder.size());
    else if (argument.starts_with(kState))
      settings.state = argument.substr(kState.size());
    else if (argument.starts_with(kLeast))
      settings.least_window = window_of(argument.substr(kLeast.size()));
    else
      return std::nullopt;
  }
  return settings;
}

int run(const Settings& settings) {
  const Signals signals;
  const auto host = host_of("");
  const auto* router = std::get_if<UnixHost>(&host);
  if (router == nullptr)
    throw usage_error("tims-agent needs the socket of the router of this host");
  const Folder folder(settings.folder);
  const Store store(settings.state);
  const Effects effects(folder, *router, signals);
  Agent agent(tims::os::now(), folder, store, effects, settings.least_window, log);
  tims::os::ServiceManager manager = tims::os::ServiceManager::of_environment();
  manager.report("READY", "1");
  (void)manager.flush();
  try {
    serve(agent, *router, signals);
  } catch (const Interrupted&) {
    log("stopped");
  }
  return 0;
}

}  // namespace
}  // namespace timsctl::configuration

int main(int argc, char** argv) {
  using namespace timsctl;
  const std::string_view first = argc > 1 ? argv[1] : "";
  if (first == "--help" || first == "-h")
    return std::fputs(configuration::kHelp.data(), stdout) < 0;
  if (first == "--version") {
    fmt::print("tims-agent {}\n", own_version());
    return 0;
  }
  try {
    const auto settings = configuration::settings_of(argc, argv);
    if (!settings) throw usage_error("unknown argument; see tims-agent --help");
    return configuration::run(*settings);
  } catch (const Failure& failure) {
    fmt::print(stderr, "{}", failure_text(failure));
    return static_cast<int>(failure.exit);
  }
}

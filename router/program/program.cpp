#include "router/program/program.h"

#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "os/clock.h"
#include "os/shared_memory.h"
#include "router/config/options.h"
#include "router/core/newest_values.h"
#include "router/core/router.h"
#include "router/io/admin_actions.h"
#include "router/io/admin_service.h"
#include "router/io/http/console_folder.h"
#include "router/io/http/http_port.h"
#include "router/io/link_port.h"
#include "router/io/local_port.h"
#include "router/io/log.h"
#include "router/io/loop.h"
#include "router/io/rights.h"
#include "router/io/service.h"
#include "router/io/subjects.h"
#include "router/io/tcp_port.h"
#include "router/io/tracer.h"
#include "router/io/waiting_memory.h"
#include "router/program/keys_in_force.h"
#include "router/program/settings.h"
#include "security/crypto/digest.h"

namespace tims::program {
namespace {

using namespace std::chrono_literals;
using security::random_number;

constexpr Duration kDrainTime = 2s;
constexpr Duration kShortDrainTime = 100ms;  // while the others wait for the next router
constexpr const char* kHandoverName = "links";

io::Clocks read_clocks(Time now) {
  return {now, std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now())};
}

std::string cannot_listen(std::string_view key, const std::string& where, const Error& error) {
  if (error == Errc::kAddressInUse)
    return fmt::format("cannot listen on {}: address in use; another router? `--set {}=...`", where,
                       key);
  return fmt::format("cannot listen: {}; `--set {}=...`", error.detail(), key);
}

// The running router, component by component, and the source of its reports.
class Program final : private core::RouterHooks, private io::AdminSource {
 public:
  Program(config::Loaded configuration, const io::Arguments& arguments)
      : configuration_(std::move(configuration)), arguments_(arguments) {
    router_.attach(core::PortKind::kLocal, local_);
    router_.attach(core::PortKind::kTcp, tcp_);
    router_.attach(core::PortKind::kWebSocket, http_);
    router_.attach(core::PortKind::kLink, links_.port());
    router_.judge_by(enforcer_);
    router_.set_static_routes(static_routes(configuration_.config));
    newest_.set_rule(newest_rule(configuration_.config));
    if (configuration_.config.newest.bytes > 0) router_.keep_newest(newest_);
    loop_.at_turn_end([this](Time now) { finish_turn(now); });
    loop_.watch({.next = [this] { return router_.next_timeout(); },
                 .on_timeout = [this](Time now) { router_.on_timeout(now); }});
    loop_.watch({.next = [this] { return admin_.next_timeout(); }, .on_timeout = [](Time) {}});
    loop_.watch({.next = [this] { return http_.next_timeout(); },
                 .on_timeout = [this](Time now) { http_.on_timeout(now); }});
    loop_.watch({.next = [this] { return links_.next_timeout(); },
                 .on_timeout = [this](Time now) { links_.on_timeout(now); }});
    loop_.watch({.next = [this] { return limited_log_.next_timeout(); },
                 .on_timeout = [this](Time now) { limited_log_.on_timeout(now); }});
    loop_.watch(
        {.next = [this] { return drain_deadline_; }, .on_timeout = [this](Time) { loop_.stop(); }});
  }

  int run() {
    const int priority = configuration_.config.router.priority;
    if (priority > 0) {
      if (const auto done = io::become_real_time(priority); !done)
        log_.warning(fmt::format("router.priority {}: {}", priority, done.error().detail()));
    }
    Result<void> result = keys_.load({links_, tcp_, http_});
    if (result) result = listen();
    if (!result) {
      log_.error(result.error().detail());
      if (former_) (void)leave(former_->encode());
      return kCannotStart;
    }
    manager_.ready();
    loop_.run();
    if (hands_over_) leave_links(os::now());
    links_.stop();
    log_.info("stopped");
    return 0;
  }

 private:
  // core::RouterHooks
  void admin(Time now, core::ClientId from, const core::Message& request) override {
    admin_.ask(now, from, request);
  }
  bool may_ask(core::ClientId from, const core::Message& request) override {
    return admin_.may_ask(from, request);
  }
  policy::Right right_of(const core::Message& request) override {
    const core::RouterSettings& settings = router_.settings();
    return io::asked_of(io::SentMessage::of(request, settings), settings.widths);
  }
  bool writes_rules(const core::ClientInfo& client) override {
    return client.port == core::PortKind::kLocal && io::is_own_user(client.uid);
  }
  void deny_admin(core::ClientId from, const core::Message& request,
                  std::string_view rule) override {
    admin_.deny(from, request, rule);
  }
  void trace_denied(core::ClientId from, const core::Message& message,
                    std::string_view rule) override {
    tracer_.on_denied(read_clocks({}).wall, from, message, rule);
  }
  void traced(core::ClientId from, core::ClientId to, const core::Message& message) override {
    tracer_.on_traced(read_clocks({}).wall, from, to, message);
  }
  void event(const core::Event& event) override {
    admin_.event_happened();
    io::log_event(log_, limited_log_, event, configuration_.config.address.widths);
  }

  // io::AdminSource
  [[nodiscard]] const core::Router& router() const override { return router_; }
  [[nodiscard]] io::ProcessReport process(Time now) const override {
    io::ProcessReport report = process_;
    report.name = configuration_.config.router.name;
    report.uptime = now - started_;
    report.rss_bytes = io::resident_bytes();
    report.longest_turn = loop_.longest_turn();
    report.udp_socket = links_.udp_report();
    report.http_refused = http_.refusals();
    report.insecure = configuration_.config.security.insecure;
    report.exposed = exposed_ports();
    report.cautions = config::cautions(configuration_.config);
    keys_.add_to(report);
    return report;
  }
  [[nodiscard]] const config::Config& config() const override { return configuration_.config; }
  [[nodiscard]] const config::Origins& origins() const override { return configuration_.origins; }
  [[nodiscard]] const link::Links* links() const override { return &links_.links(); }
  [[nodiscard]] std::optional<io::DdsReport> dds() const override { return links_.dds_report(); }
  core::LeaseResult change_lease(Time now, core::ClientId from, core::LeaseVerb verb,
                                 const core::DrivingLease& holder) override {
    return router_.change_lease(now, from, verb, holder);
  }
  [[nodiscard]] const io::Person* person(core::PortKind port, std::uint32_t token) const override {
    if (port == core::PortKind::kTcp) return tcp_.person(token);
    return port == core::PortKind::kWebSocket ? http_.person(token) : nullptr;
  }
  std::optional<std::string> make_login(Time now, const io::Person& person, bool bearer) override {
    if (!keys_.exist()) return std::nullopt;
    return bearer ? http_.logins().begin(now, person) : http_.logins().offer(now, person);
  }
  bool act_on_link(std::string_view name, link::Links::Action what) override {
    return links_.act(name, what);
  }
  bool inject_faults(std::string_view name, const link::Faults& faults) override {
    return links_.inject_faults(name, faults);
  }
  [[nodiscard]] const link::Faults* faults_of(const link::Link& link) const override {
    return links_.faults_of(link);
  }
  void set_static_routes(const std::vector<core::StaticRoute>& routes) override {
    router_.set_static_routes(routes);
  }
  void changed(Time now, core::ClientId by, std::string_view what) override {
    const core::Client* client = router_.client(by);
    router_.note({.at = now,
                  .kind = core::EventKind::kRouterChanged,
                  .client = client == nullptr ? core::Peer{} : client->peer(),
                  .text = what});
  }
  [[nodiscard]] std::optional<io::MailboxFill> fill(std::uint32_t handle) const override {
    return local_.fill(handle);
  }
  [[nodiscard]] shm::Counters mailbox_counts() const override { return local_.mailbox_counts(); }
  [[nodiscard]] std::uint64_t queued_bytes(core::PortKind port,
                                           std::uint32_t token) const override {
    return router_.queued_bytes(port, token);
  }

  void finish_turn(Time now) {
    router_.flush(now);
    if (admin_.has_work(now) || tracer_.has_records()) answer(now);
    links_.release();
    queue_memory_.give_back();
    link_memory_.give_back();
    if (drain_deadline_ != kNever && router_.drained()) loop_.stop();
  }

  void answer(Time now) {
    const io::Clocks clocks = read_clocks(now);
    admin_.answer(clocks, [&](core::ClientId asker, core::Message& answer) {
      router_.answer(now, asker, answer);
    });
    tracer_.send_records(router_, configuration_.config.router.name,
                         [&](core::Message& record) { router_.answer(now, {}, record); });
    router_.flush(now);
    admin_.release();
    tracer_.release();
    if (!admin_.needs_turn() || admin_has_turn_) return;
    admin_has_turn_ = true;
    loop_.post([this] {
      admin_has_turn_ = false;
      loop_.end_turn(os::now());
    });
  }

  Result<void> listen() {
    const config::Config& c = configuration_.config;
    if (auto result = local_.listen(manager_.sockets()); !result) {
      return Error(result.error().code(), cannot_listen("unix.path", c.unix.path, result.error()));
    }
    process_.unix_path = c.unix.path;
    log_.info("listening unix " + c.unix.path);
    if (auto result = listen(tcp_, "tcp", c.tcp.listen, process_.tcp); !result) return result;
    if (auto result = listen(http_, "http", c.http.listen, process_.http); !result) return result;
    if (auto result = listen_for_routers(c); !result) return result;
    for (const std::string& name : manager_.sockets().forget_rest())
      log_.info("the service manager's socket " + name + " is in no setting: closed");
    links_.configure(os::now(), c);
    if (former_) {
      const std::size_t links = links_.restore(os::now(), std::move(*former_));
      former_.reset();
      log_.info(fmt::format("links that go on from the former router: {}", links));
    }
    for (const std::string& caution : config::cautions(c)) log_.warning(caution);
    if (const auto exposed = exposed_ports(); !exposed.empty())
      log_.warning(
          fmt::format("{}: open to the network without keys (security.insecure): anybody "
                      "in this network can drive this robot",
                      fmt::join(exposed, ", ")));
    return {};
  }

  // Names of the ports that listen beyond loopback, where nobody is asked who he is.
  [[nodiscard]] std::vector<std::string> exposed_ports() const {
    std::vector<std::string> names;
    if (keys_.exist()) return names;  // links and connections with keys are open to the fleet only
    for (const auto& [name, where] :
         {std::pair("tcp", &process_.tcp), std::pair("http", &process_.http),
          std::pair("udp", &process_.udp)})
      if (const auto endpoint = config::Endpoint::parse(*where); endpoint && !endpoint->loopback())
        names.emplace_back(name);
    return names;
  }

  // A router without its console still carries messages, so the reason is only logged and shown.
  std::shared_ptr<const io::ConsoleFiles> load_console() {
    const config::Config::Http& http = configuration_.config.http;
    std::string reason = "It is switched off: http.console is \"off\".";
    if (http.listen && http.console != "off") {
      const bool by_default = http.console.empty();
      const std::string folder = by_default ? io::default_console_folder() : http.console;
      auto files = io::read_console(folder);
      if (files) {
        process_.console = folder;
        log_.info(
            fmt::format("console {}: {} files, {} bytes", folder, files->size(), files->bytes()));
        return std::make_shared<const io::ConsoleFiles>(std::move(*files));
      }
      reason = files.error().detail();
      if (!by_default || ::access(folder.c_str(), F_OK) == 0)
        log_.warning("no console: " + reason + "; see http.console");
    }
    return std::make_shared<const io::ConsoleFiles>(io::ConsoleFiles::without_console(reason));
  }

  // A router without links has no UDP socket.
  Result<void> listen_for_routers(const config::Config& c) {
    if (!c.links.empty() && !links_.is_open() && c.udp.listen) {
      const auto where = links_.listen(*c.udp.listen, manager_.sockets());
      if (!where) {
        return Error(where.error().code(),
                     cannot_listen("udp.listen", c.udp.listen->to_string(), where.error()));
      }
      process_.udp = *where;
      log_.info("listening udp " + *where);
    }
    const auto by_tcp = links_.open_tcp(c, manager_.sockets());
    if (!by_tcp) {
      return Error(by_tcp.error().code(),
                   cannot_listen("udp.listen", c.udp.listen->to_string(), by_tcp.error()));
    }
    if (!by_tcp->empty()) log_.info("links over tcp at " + *by_tcp);
    if (!c.fleet.name.empty() && !links_.is_in_fleet()) {
      if (const auto joined = links_.join(c); !joined)
        return Error(joined.error().code(), fmt::format("cannot join the fleet {}: {}",
                                                        c.fleet.name, joined.error().detail()));
      log_.info(fmt::format("in fleet {} by dds, domain {}{}", c.fleet.name, c.dds.domain,
                            c.dds_leaves_host() ? "" : ", on this host only"));
    }
    return {};
  }

  // `endpoint`: empty when the port is switched off. `where` receives the listening address.
  template <typename TcpOrHttpPort>
  Result<void> listen(TcpOrHttpPort& port, std::string_view name,
                      const std::optional<config::Endpoint>& endpoint, std::string& where) {
    if (!endpoint) return {};
    const auto listening = port.listen(*endpoint, &manager_.sockets());
    if (!listening) {
      return Error(
          listening.error().code(),
          cannot_listen(fmt::format("{}.listen", name), endpoint->to_string(), listening.error()));
    }
    where = listening->to_string();
    log_.info(fmt::format("listening {} {}", name, where));
    return {};
  }

  // Data queued for slow readers is still written for a while.
  void stop() {
    if (drain_deadline_ != kNever) return;
    const Time now = os::now();
    manager_.stopping();
    log_.info("stopping");
    if (links_.is_open()) links_.end(now);
    router_.stop_accepting();
    drain_deadline_ = now + kDrainTime;
    loop_.end_turn(now);
  }

  // For a restart: the links are left to the next router, to which its host's programs connect.
  void hand_over() {
    if (drain_deadline_ != kNever) return;
    const Time now = os::now();
    manager_.stopping();
    log_.info("stopping for a restart");
    hands_over_ = true;
    router_.stop_accepting();
    links_.announce_pause(now);
    drain_deadline_ = now + kShortDrainTime;
    loop_.end_turn(now);
  }

  void leave_links(Time now) {
    if (leave(links_.links().save(now))) return;
    log_.info("nobody keeps the links for the next router: they end");
    if (links_.is_open()) links_.end(now);
  }

  // Returns whether somebody keeps it for the next router.
  bool leave(const std::vector<std::byte>& state) {
    const auto memory = os::make_memfd(kHandoverName, state);
    if (!memory) log_.error("links are not left to the next router: " + memory.error().detail());
    return memory && manager_.sockets().keep_memory(kHandoverName, memory->get());
  }

  // What the former router has left; empty: this one starts anew.
  std::optional<link::Handover> inherit() {
    const os::File memory = manager_.sockets().take_memory(kHandoverName);
    if (!memory) return std::nullopt;
    const auto bytes = os::read_memfd(memory, link::Handover::kBytesMax);
    auto former = bytes ? link::Handover::decode(os::now(), *bytes) : bytes.error();
    if (former && former->self != identity(configuration_.config, former->self.epoch))
      former = Error(Errc::kInvalidArgument, "it was left by a router with other settings");
    if (former) return std::move(*former);
    log_.warning("links begin anew, since what the former router has left cannot be used: " +
                 former.error().detail());
    return std::nullopt;
  }

  void reload() {
    manager_.reloading();
    const auto loaded = load_configuration(arguments_);
    if (!loaded) {
      log_.error("not reloaded: " + loaded.error().message());
    } else if (!loaded->ok()) {
      for (const auto& problem : loaded->problems) {
        log_.error("not reloaded: " + problem.to_string());
      }
    } else {
      apply(*loaded);
    }
    manager_.ready();
  }

  // Applies all changes or none: steps that may fail come first.
  void apply(const config::Loaded& loaded) {
    const Time now = os::now();
    config::Config wanted = config::reloaded(configuration_.config, loaded.config);
    if (const auto listening = listen_for_routers(wanted); !listening)
      return log_.error("not reloaded: " + listening.error().detail());
    for (const auto& change : config::changes(configuration_.config, loaded.config)) {
      log_.info("reloaded: " + change.to_string());
    }
    router_.set_static_routes(io::reload_routes(router_.routes().all_static(),
                                                static_routes(configuration_.config),
                                                static_routes(wanted)));
    const policy::PolicyText former_policy = policy_text(configuration_);
    configuration_.config = std::move(wanted);
    configuration_.origins = loaded.origins;
    if (policy_text(configuration_) != former_policy)
      router_.set_policy(now, policy_of(configuration_));
    const config::Config& c = configuration_.config;
    log_.set_level(c.log.level);
    router_.configure(now, router_settings(c, epoch_));
    links_.configure(now, c);
    newest_.set_rule(newest_rule(c));
    keys_.configure();
    http_.set_access(browser_access(c));
    tcp_.set_queue_bytes_max(c.tcp.queue_bytes);
    http_.set_queue_bytes_max(c.http.queue_bytes);
    http_.set_ping_interval(c.lifesign.interval);
    loop_.end_turn(now);
  }

  config::Loaded configuration_;
  const io::Arguments& arguments_;
  io::Log log_{configuration_.config.log.level};
  io::Loop loop_;
  // From here on a signal to end is obeyed in order, when the loop runs: before, it ends a router
  // that has taken nothing over.
  io::Signals signals_{loop_,
                       {.stop = [this] { stop(); },
                        .reload = [this] { reload(); },
                        .hand_over = [this] { hand_over(); }}};
  io::Service manager_{loop_};
  std::optional<link::Handover> former_ = inherit();  // until the links are restored
  // For the others, a router that goes on is the same one.
  const std::uint64_t epoch_ = former_ ? former_->self.epoch : random_number();
  const Time started_ = os::now();
  io::ProcessReport process_{.version = TIMS_VERSION,
                             .pid = static_cast<std::uint32_t>(::getpid()),
                             .uid = ::getuid(),
                             // Values that never change, and the listening addresses.
                             .epoch = epoch_};
  io::LimitedLog limited_log_{log_};
  KeysInForce keys_{loop_, log_, limited_log_, configuration_.config};
  core::Router router_{
      router_settings(configuration_.config, epoch_), {random_number(), random_number()}, *this};
  policy::Enforcer enforcer_{policy_of(configuration_), random_number()};
  core::NewestValues newest_{configuration_.config.newest.bytes,
                             {random_number(), random_number()}};
  // Queues of TCP and WebSocket clients are separate from the memory of links.
  io::WaitingMemory queue_memory_{waiting_bytes(configuration_.config)};
  core::QueueShares queue_shares_{queue_memory_.pool()};
  io::WaitingMemory link_memory_{waiting_bytes(configuration_.config)};
  io::LocalPort local_{loop_,
                       router_,
                       log_,
                       {.path = configuration_.config.unix.path,
                        .everybody = configuration_.config.unix.everybody,
                        .router = router_settings(configuration_.config, epoch_).address,
                        .epoch = random_number(),
                        .message_max = configuration_.config.message.bytes_max}};
  io::TcpPort tcp_{loop_,
                   router_,
                   log_,
                   queue_shares_,
                   {.message_max = configuration_.config.message.bytes_max,
                    .queue_bytes_max = configuration_.config.tcp.queue_bytes}};
  io::LinkPort links_{
      loop_,
      router_,
      log_,
      link_memory_.pool(),
      {.self = identity(configuration_.config, epoch_),
       .secret = {random_number(), random_number()},
       .clock = os::now},
      configuration_.config.security.keys,
      [this](Time now, io::CheckedList&& list) { keys_.take_list(now, std::move(list)); }};
  io::HttpPort http_{loop_,
                     router_,
                     log_,
                     limited_log_,
                     queue_shares_,
                     *this,
                     {.message_max = configuration_.config.message.bytes_max,
                      .queue_bytes_max = configuration_.config.http.queue_bytes,
                      .ping_interval = configuration_.config.lifesign.interval,
                      .access = browser_access(configuration_.config),
                      .console = load_console()}};
  io::AdminService admin_{*this};
  bool admin_has_turn_ = false;  // posted
  io::Tracer tracer_;
  Time drain_deadline_ = kNever;  // set when shutdown begins
  bool hands_over_ = false;
};

}  // namespace

int run(config::Loaded configuration, const io::Arguments& arguments) {
  return Program(std::move(configuration), arguments).run();
}

}  // namespace tims::program

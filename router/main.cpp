// tims-router: creates the components, in order of the members, and runs them.
#include <cstdio>
#include <cstring>
#include <new>
#include <span>
#include <string>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include "base/measure.h"
#include "os/clock.h"
#include "os/environment.h"
#include "os/shared_memory.h"
#include "router/config/load.h"
#include "router/config/networks.h"
#include "router/config/options.h"
#include "router/core/newest_values.h"
#include "router/core/router.h"
#include "router/io/admin_actions.h"
#include "router/io/admin_service.h"
#include "router/io/arguments.h"
#include "router/io/http/console_folder.h"
#include "router/io/http/http_port.h"
#include "router/io/link_port.h"
#include "router/io/local_port.h"
#include "router/io/log.h"
#include "router/io/loop.h"
#include "router/io/member_keys.h"
#include "router/io/net/resolver.h"
#include "router/io/renewal.h"
#include "router/io/service.h"
#include "router/io/subjects.h"
#include "router/io/tcp_port.h"
#include "router/io/tls_gate.h"
#include "router/io/tracer.h"
#include "router/io/waiting_memory.h"
#include "security/crypto/digest.h"
#include "security/keys/join_client.h"

namespace tims {
namespace {

using namespace std::chrono_literals;

constexpr int kCannotStart = 1;
constexpr int kWrongUsage = 2;
constexpr Duration kDrainTime = 2s;
constexpr Duration kShortDrainTime = 100ms;  // while the others wait for the next router
constexpr const char* kHandoverName = "links";
constexpr std::size_t kWaitingBytesMin = 256 << 20;  // address space, not memory
constexpr std::size_t kFullQueues = 16;              // number of full queues that fit into it

config::Host this_host() {
  return {.name = os::host_name(), .uid = ::getuid(), .environment = os::environment()};
}

Result<config::Loaded> load_configuration(const io::Arguments& arguments) {
  config::Sources sources{.files = {}, .settings = arguments.settings, .host = this_host()};
  if (!arguments.config_path.empty()) {
    auto files = config::read_files(arguments.config_path);
    if (!files) return files.error();
    sources.files = std::move(*files);
  }
  return config::load(sources);
}

core::RouterSettings router_settings(const config::Config& c, std::uint64_t epoch) {
  return {.address =
              Address::of({.system = c.router.system, .instance = c.router.id}, c.address.widths),
          .widths = c.address.widths,
          .classes = c.message.classes,
          .role = c.router.role,
          .epoch = static_cast<std::uint32_t>(epoch),
          .compat_delete = c.tcp.compat_delete,
          .lifesign_interval = c.lifesign.interval,
          .clients_max = c.limits.clients,
          .mailboxes_per_client_max = c.limits.mailboxes_per_client};
}

link::Identity identity(const config::Config& c, std::uint64_t epoch) {
  return {.epoch = epoch,
          .role = c.router.role,
          .system = c.router.system,
          .id = c.router.id,
          .name = std::string_view(c.router.name),
          .widths = c.address.widths,
          .message_max = c.message.bytes_max,
          .classes = c.message.classes.at(c.address.widths)};
}

std::vector<core::StaticRoute> static_routes(const config::Config& c) {
  std::vector<core::StaticRoute> routes;
  routes.reserve(c.routes.size());
  for (const config::Route& route : c.routes) {
    routes.push_back({*AddressPattern::parse(route.match, c.address.widths),
                      std::string_view(route.match), std::string_view(route.via)});
  }
  return routes;
}

std::size_t waiting_bytes(const config::Config& c) {
  const std::size_t queue = std::max({c.tcp.queue_bytes, c.http.queue_bytes, c.message.bytes_max});
  return std::max(kWaitingBytesMin, kFullQueues * queue);
}

io::BrowserAccess browser_access(const config::Config& c) {
  return {.names = config::list_of(c.http.names),
          .origins = config::list_of(c.http.origins),
          .login = !c.security.keys.empty()};
}

// The configuration has been checked; what cannot be parsed would let nobody in.
config::Networks plain_networks(const config::Config& c) {
  return config::Networks::parse(c.tcp.plain).value_or({});
}

core::NewestRule newest_rule(const config::Config& c) {
  core::NewestRule rule{.length_max = c.newest.length_max, .widths = c.address.widths};
  for (const std::string& stream : config::list_of(c.newest.streams)) (void)rule.add(stream);
  return rule;
}

policy::PolicyText policy_text(const config::Origins& origins, const config::Config& c) {
  return config::policy_text(c, config::rule_places(origins));
}

policy::Policy policy_of(const config::Loaded& loaded) {
  const config::Config& c = loaded.config;
  std::vector<policy::Problem> problems;  // none: the configuration was checked
  auto policy = policy::Policy::compile(policy_text(loaded.origins, c), c.address.widths, problems);
  return policy ? std::move(*policy) : policy::Policy(c.address.widths);
}

std::uint64_t random_number() {
  std::uint64_t number = 0;
  security::fill_random(std::as_writable_bytes(std::span(&number, 1)));
  return number;
}

io::Clocks read_clocks(Time now) {
  return {now, std::chrono::time_point_cast<Duration>(std::chrono::system_clock::now())};
}

io::KeysReport keys_report(const io::MemberKeys& keys) {
  const security::Credentials& own = keys.credentials();
  return {.fleet = own.identity.fleet,
          .identity = own.identity.to_string(),
          .state = std::string(security::state_of(own, security::system_check_time(own.passed()))),
          .ends = fmt::format("{:%FT%TZ}",
                              fmt::gmtime(static_cast<std::time_t>(own.chain.front().not_after()))),
          .list = own.list_number(),
          .revoked = own.list ? own.list->size() : 0,
          .problem = keys.problem()};
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
    Result<void> result = load_keys();
    if (result) result = listen();
    if (!result) {
      log_.error(result.error().detail());
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
    if (keys_ && keys_->has_old_list()) report.cautions.push_back(old_list_text());
    if (keys_) report.keys = keys_report(*keys_);
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
    if (!keys_) return std::nullopt;
    return bearer ? http_.logins().begin(now, person) : http_.logins().offer(now, person);
  }
  bool act_on_link(std::string_view name, link::Links::Action what) override {
    return links_.act(name, what);
  }
  bool inject_faults(std::string_view name, const link::Faults& faults) override {
    return links_.inject_faults(name, faults);
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
    links_.look_who_is_back(now);
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

  Result<void> load_keys() {
    if (configuration_.config.security.keys.empty()) return {};
    auto keys = io::MemberKeys::load(configuration_.config);
    if (!keys) return keys.error();
    keys_ = std::move(*keys);
    believed_ = keys_->credentials().roots;
    log_.info(describe_keys());
    if (auto used = links_.use_keys(os::now(), keys_->credentials(), keys_->strictness()); !used)
      return Error(used.error().code(), "security.keys: " + used.error().detail());
    if (auto opened = open_gate(); !opened) return opened;
    loop_.watch({.next = [this] { return keys_->next_timeout(); },
                 .on_timeout = [this](Time now) { look_at_keys(now); }});
    renew_keys_in_time();
    return {};
  }

  // The base renews its own certificate itself (timsctl key serve).
  void renew_keys_in_time() {
    if (keys_->folder().has("authority")) return;
    renewal_.emplace(loop_, log_,
                     io::Renewal::Steps{.is_due = [this] { return is_renewal_due(); },
                                        .prepare =
                                            [this] {
                                              return [folder = keys_->folder(),
                                                      hosts = hosts_above()](Time deadline) {
                                                return security::renew_certificate(folder, hosts,
                                                                                   deadline);
                                              };
                                            }},
                     renewal_time());
    loop_.watch({.next = [this] { return renewal_->next_timeout(); },
                 .on_timeout = [this](Time now) { renewal_->on_timeout(now); }});
  }
  // Not at once: after a start the network is not there yet.
  [[nodiscard]] Time renewal_time() const {
    const Duration within = configuration_.config.security.renew_within;
    const Duration spread = within - within / 10;
    return os::now() + within / 10 +
           Duration(random_number() % (static_cast<std::uint64_t>(spread.count()) + 1));
  }
  [[nodiscard]] bool is_renewal_due() const {
    const security::Credentials& own = keys_->credentials();
    const security::Certificate& certificate = own.chain.front();
    return has_old_root(own) ||
           security::is_renewal_due(security::system_check_time(own.passed()),
                                    certificate.not_before(), certificate.not_after());
  }
  // The authority is likely to be on the way up.
  [[nodiscard]] std::vector<std::string> hosts_above() const {
    std::vector<std::string> hosts;
    for (const config::Link& link : configuration_.config.links)
      if (link.kind == core::LinkKind::kSuper && !link.accepts() && !link.is_automatic())
        hosts.push_back(link.host);
    return hosts;
  }

  [[nodiscard]] Result<io::TlsGate::Contexts> tls_contexts() const {
    const config::Config::Http& http = configuration_.config.http;
    return io::TlsGate::contexts_of(keys_->credentials(), keys_->strictness(), http.certificate,
                                    http.key);
  }

  // Plain HTTP is let in: the port tells it to use HTTPS.
  Result<void> open_gate() {
    auto contexts = tls_contexts();
    if (!contexts) return contexts.error();
    auto gate = io::TlsGate::open(loop_, limited_log_, std::move(*contexts));
    if (!gate) return gate.error();
    gate_ = std::move(*gate);
    const auto is_plain = [this](const io::Visitor& visitor) {
      return plain_networks_.contains(visitor.peer);
    };
    tcp_.guard_by(*gate_, {io::TlsGate::Kind::kTcp, is_plain},
                  [this](const security::Certificate& certificate) -> std::optional<io::Person> {
                    const security::Identity& own = keys_->credentials().identity;
                    const auto identity = security::identity_of(certificate, own.fleet);
                    if (!identity) return std::nullopt;
                    return io::person_of(*identity, certificate, own);
                  });
    http_.guard_by(*gate_, {io::TlsGate::Kind::kHttp, [](const io::Visitor&) { return true; }});
    return {};
  }

  // Connections and logins by certificates that are revoked, or whose root has gone, end at once.
  void take_new_keys() {
    if (auto contexts = tls_contexts())
      gate_->set_contexts(std::move(*contexts));
    else
      log_.error("former keys stay in force: " + contexts.error().detail());
    const security::Credentials& own = keys_->credentials();
    const auto list = own.list;
    const auto is_revoked = [list](const security::Certificate& certificate) {
      return list && list->revokes(certificate);
    };
    gate_->end_if([is_revoked, roots = security::BelievedRoots(own.roots)](
                      const std::vector<security::Certificate>& chain) mutable {
      return is_revoked(chain.front()) || chain.size() < 2 || !roots.have_signed(chain[1].to_der());
    });
    const bool root_has_gone = std::ranges::any_of(
        std::exchange(believed_, own.roots),
        [&](const auto& root) { return std::ranges::find(own.roots, root) == own.roots.end(); });
    http_.end_if([&](const io::Person& person) {
      return person.certificate && (root_has_gone || is_revoked(*person.certificate));
    });
  }

  [[nodiscard]] std::string describe_keys() const {
    const security::Credentials& own = keys_->credentials();
    return fmt::format("keys {}: {} of the fleet {}, list {} with {} revoked",
                       keys_->folder().path(), own.identity.to_string(), own.identity.fleet,
                       own.list_number(), own.list ? own.list->size() : 0);
  }

  [[nodiscard]] std::string old_list_text() const {
    const config::Config::Security& security = configuration_.config.security;
    return fmt::format(
        "the list of revoked certificates (number {}) is older than security.list_age_max ({}): is "
        "the base reached, and does timsctl key serve run there?{}",
        keys_->credentials().list_number(),
        base::human_duration(std::chrono::duration<double>(security.list_age_max).count()),
        security.refuse_old_list ? " Users and routers of other robots are refused" : "");
  }
  // One line when it becomes old.
  void look_at_age_of_list() {
    const bool was_old = std::exchange(list_is_old_, keys_->has_old_list());
    if (list_is_old_ && !was_old) log_.warning(old_list_text());
  }

  void look_at_keys(Time now) {
    look_at_age_of_list();
    const auto changed = keys_->on_timeout(now);
    if (!changed) return log_.error("former keys stay in force: " + keys_->problem());
    if (*changed) use_new_keys(now);
  }

  void take_list(Time now, io::CheckedList&& list) {
    if (!list.not_stored.empty())
      log_.error(
          fmt::format("list {} of the fleet is in force, but only until this router ends: {}",
                      list.number, list.not_stored));
    if (keys_->use_list(std::move(list.list), list.bytes)) use_new_keys(now);
  }

  void use_new_keys(Time now) {
    log_.info(describe_keys());
    if (renewal_) renewal_->look_at(renewal_time());
    const auto used = links_.use_keys(now, keys_->credentials(), keys_->strictness());
    if (!used) log_.error("links use the former keys: " + used.error().detail());
    take_new_keys();
    loop_.end_turn(now);
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
    if (keys_) return names;  // links and connections with keys are open to the fleet only
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
    drain_deadline_ = now + kShortDrainTime;
    loop_.end_turn(now);
  }

  void leave_links(Time now) {
    const auto memory = os::make_memfd(kHandoverName, links_.save(now));
    if (!memory) log_.error("links are not left to the next router: " + memory.error().detail());
    if (memory && manager_.sockets().keep_memory(kHandoverName, memory->get())) return;
    log_.info("nobody keeps the links for the next router: they end");
    if (links_.is_open()) links_.end(now);
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
    const bool same_policy = policy_text(loaded.origins, wanted) ==
                             policy_text(configuration_.origins, configuration_.config);
    configuration_.config = std::move(wanted);
    configuration_.origins = loaded.origins;
    if (!same_policy) router_.set_policy(now, policy_of(configuration_));
    const config::Config& c = configuration_.config;
    log_.set_level(c.log.level);
    router_.configure(now, router_settings(c, epoch_));
    links_.configure(now, c);
    newest_.set_rule(newest_rule(c));
    plain_networks_ = plain_networks(c);
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
  std::optional<io::MemberKeys> keys_;  // empty: without keys
  bool list_is_old_ = false;
  std::vector<security::Certificate> believed_;  // roots, when the keys were taken last
  std::unique_ptr<io::TlsGate> gate_;            // null: without keys
  std::optional<io::Renewal> renewal_;           // empty: without keys, or at the base
  config::Networks plain_networks_ = plain_networks(configuration_.config);  // TCP without TLS
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
      [this](Time now, io::CheckedList&& list) { take_list(now, std::move(list)); }};
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
  io::Signals signals_{loop_,
                       {.stop = [this] { stop(); },
                        .reload = [this] { reload(); },
                        .hand_over = [this] { hand_over(); }}};
  Time drain_deadline_ = kNever;  // set when shutdown begins
  bool hands_over_ = false;
};

// The system refuses memory, because of a limit or because there is none. What was begun cannot be
// completed without it; a sentence is better than the name of an exception. Called instead of
// throwing it, in every thread.
[[noreturn]] void end_without_memory() {
  constexpr std::string_view kText =
      "tims-router: the system refuses more memory: raise the limit of the process (ulimit -v, "
      "ulimit -d; LimitAS, MemoryMax of its service), or lower tcp.queue, "
      "http.queue and message.max\n";
  (void)!::write(STDERR_FILENO, kText.data(), kText.size());
  ::_exit(kCannotStart);
}

int print(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stdout);
  return std::fflush(stdout) == 0 ? 0 : kCannotStart;
}

int complain(std::string_view text, int status) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fputc('\n', stderr);
  return status;
}

int main(std::span<const char* const> argv) {
  using Action = io::Arguments::Action;
  const auto arguments = io::parse_arguments(argv);
  if (!arguments) {
    return complain(arguments.error().detail() + "; see tims-router --help", kWrongUsage);
  }
  if (arguments->action == Action::kVersion) return print("tims-router " TIMS_VERSION "\n");
  if (arguments->action == Action::kHelp) {
    return print(io::usage() + "\nKeys and values:\n" + config::options_help());
  }
  auto loaded = load_configuration(*arguments);
  if (!loaded) return complain(loaded.error().message(), kCannotStart);
  for (const auto& problem : loaded->problems) complain(problem.to_string(), kCannotStart);
  if (!loaded->ok()) return kCannotStart;
  if (arguments->action == Action::kCheck) {
    for (const std::string& caution : config::cautions(loaded->config)) complain(caution, 0);
    return print("the configuration is valid\n");
  }
  if (arguments->action == Action::kPrintConfig) {
    return print(config::print_config(loaded->config, loaded->origins));
  }
  io::raise_descriptor_limit();
  io::limit_name_servers();
  return Program(std::move(*loaded), *arguments).run();
}

}  // namespace
}  // namespace tims

int main(int count, char** argv) {
  std::set_new_handler(tims::end_without_memory);
  return tims::main(
      {const_cast<const char* const*>(argv) + 1, static_cast<std::size_t>(count) - 1});
}

#include "router/program/keys_in_force.h"

#include <algorithm>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "base/measure.h"
#include "os/clock.h"
#include "router/io/subjects.h"
#include "router/program/settings.h"
#include "security/crypto/digest.h"
#include "security/keys/join_client.h"

namespace tims::program {
namespace {

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

}  // namespace

KeysInForce::KeysInForce(io::Loop& loop, io::Log& log, io::LimitedLog& limited_log,
                         const config::Config& config)
    : loop_(loop),
      log_(log),
      limited_log_(limited_log),
      config_(config),
      plain_networks_(plain_networks(config)) {}

Result<void> KeysInForce::load(const Ports& ports) {
  if (config_.security.keys.empty()) return {};
  auto keys = io::MemberKeys::load(config_);
  if (!keys) return keys.error();
  ports_.emplace(ports);
  keys_ = std::move(*keys);
  believed_ = keys_->credentials().roots;
  log_.info(description());
  if (auto used = ports_->links.use_keys(os::now(), keys_->credentials(), keys_->strictness());
      !used)
    return Error(used.error().code(), "security.keys: " + used.error().detail());
  if (auto opened = open_gate(); !opened) return opened;
  loop_.watch({.next = [this] { return keys_->next_timeout(); },
               .on_timeout = [this](Time now) { look(now); }});
  renew_in_time();
  return {};
}

// The base renews its own certificate itself (timsctl key serve).
void KeysInForce::renew_in_time() {
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
Time KeysInForce::renewal_time() const {
  const Duration within = config_.security.renew_within;
  const Duration spread = within - within / 10;
  return os::now() + within / 10 +
         Duration(security::random_number() % (static_cast<std::uint64_t>(spread.count()) + 1));
}

bool KeysInForce::is_renewal_due() const {
  const security::Credentials& own = keys_->credentials();
  const security::Certificate& certificate = own.chain.front();
  return has_old_root(own) ||
         security::is_renewal_due(security::system_check_time(own.passed()),
                                  certificate.not_before(), certificate.not_after());
}

// The authority is likely to be on the way up.
std::vector<std::string> KeysInForce::hosts_above() const {
  std::vector<std::string> hosts;
  for (const config::Link& link : config_.links)
    if (link.kind == core::LinkKind::kSuper && !link.accepts() && !link.is_automatic())
      hosts.push_back(link.host);
  return hosts;
}

Result<io::TlsGate::Contexts> KeysInForce::tls_contexts() const {
  const config::Config::Http& http = config_.http;
  return io::TlsGate::contexts_of(keys_->credentials(), keys_->strictness(), http.certificate,
                                  http.key);
}

// Plain HTTP is let in: the port tells it to use HTTPS.
Result<void> KeysInForce::open_gate() {
  auto contexts = tls_contexts();
  if (!contexts) return contexts.error();
  auto gate = io::TlsGate::open(loop_, limited_log_, std::move(*contexts));
  if (!gate) return gate.error();
  gate_ = std::move(*gate);
  const auto is_plain = [this](const io::Visitor& visitor) {
    return plain_networks_.contains(visitor.peer);
  };
  ports_->tcp.guard_by(
      *gate_, {io::TlsGate::Kind::kTcp, is_plain},
      [this](const security::Certificate& certificate) -> std::optional<io::Person> {
        const security::Identity& own = keys_->credentials().identity;
        const auto identity = security::identity_of(certificate, own.fleet);
        if (!identity) return std::nullopt;
        return io::person_of(*identity, certificate, own);
      });
  ports_->http.guard_by(*gate_,
                        {io::TlsGate::Kind::kHttp, [](const io::Visitor&) { return true; }});
  return {};
}

// Connections and logins by certificates that are revoked, or whose root has gone, end at once.
void KeysInForce::replace_at_gate() {
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
  ports_->http.end_if([&](const io::Person& person) {
    return person.certificate && (root_has_gone || is_revoked(*person.certificate));
  });
}

std::string KeysInForce::description() const {
  const security::Credentials& own = keys_->credentials();
  return fmt::format("keys {}: {} of the fleet {}, list {} with {} revoked", keys_->folder().path(),
                     own.identity.to_string(), own.identity.fleet, own.list_number(),
                     own.list ? own.list->size() : 0);
}

std::string KeysInForce::old_list_text() const {
  const config::Config::Security& security = config_.security;
  return fmt::format(
      "the list of revoked certificates (number {}) is older than security.list_age_max ({}): is "
      "the base reached, and does timsctl key serve run there?{}",
      keys_->credentials().list_number(),
      base::human_duration(std::chrono::duration<double>(security.list_age_max).count()),
      security.refuse_old_list ? " Users and routers of other robots are refused" : "");
}

// One line when it becomes old.
void KeysInForce::look_at_age_of_list() {
  const bool was_old = std::exchange(list_is_old_, keys_->has_old_list());
  if (list_is_old_ && !was_old) log_.warning(old_list_text());
}

void KeysInForce::look(Time now) {
  look_at_age_of_list();
  const auto changed = keys_->on_timeout(now);
  if (!changed) return log_.error("former keys stay in force: " + keys_->problem());
  if (*changed) use_new(now);
}

void KeysInForce::take_list(Time now, io::CheckedList&& list) {
  if (!list.not_stored.empty())
    log_.error(fmt::format("list {} of the fleet is in force, but only until this router ends: {}",
                           list.number, list.not_stored));
  if (keys_->use_list(std::move(list.list), list.bytes)) use_new(now);
}

void KeysInForce::use_new(Time now) {
  log_.info(description());
  if (renewal_) renewal_->look_at(renewal_time());
  const auto used = ports_->links.use_keys(now, keys_->credentials(), keys_->strictness());
  if (!used) log_.error("links use the former keys: " + used.error().detail());
  replace_at_gate();
  loop_.end_turn(now);
}

void KeysInForce::configure() { plain_networks_ = plain_networks(config_); }

void KeysInForce::add_to(io::ProcessReport& report) const {
  if (!keys_) return;
  if (keys_->has_old_list()) report.cautions.push_back(old_list_text());
  report.keys = keys_report(*keys_);
}

}  // namespace tims::program

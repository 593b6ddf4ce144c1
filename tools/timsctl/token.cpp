// timsctl token new, list, revoke; join; key serve: how a robot comes into a fleet.
#include <algorithm>
#include <iostream>

#include <fmt/format.h>

#include "base/text.h"
#include "os/clock.h"
#include "os/environment.h"
#include "os/file.h"
#include "security/keys/join_client.h"
#include "security/keys/join_server.h"
#include "tools/cli/service.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/key.h"

namespace timsctl {

using security::Authority;
using security::Certificate;
using security::Identity;
using security::JoinServer;
using security::JoinText;
using security::KeyFolder;
using security::MemberRole;
using security::Token;
using security::Tokens;

namespace {

constexpr tims::Duration kJoinPatience = std::chrono::seconds(15);
constexpr tims::Duration kLookAtTokens = std::chrono::seconds(10);
constexpr tims::Duration kLookAtOwn = std::chrono::hours(1);

constexpr Column kTokenColumns[] = {
    {.title = "ID", .path = "id"},       {.title = "FOR", .path = "for"},
    {.title = "STATE", .path = "state"}, {.title = "MADE", .path = "made"},
    {.title = "ENDS", .path = "ends"},
};

std::vector<std::string> wanted_addresses(const std::string& list) {
  if (list.empty()) {
    std::vector<std::string> hosts = own_addresses();
    if (hosts.size() > JoinText::kHostsMax - 1) hosts.resize(JoinText::kHostsMax - 1);
    return hosts;
  }
  std::vector<std::string> hosts;
  for (std::string_view left = list; !left.empty();) {
    const std::size_t comma = std::min(left.find(','), left.size());
    hosts.emplace_back(base::trimmed(left.substr(0, comma)));
    left.remove_prefix(std::min(comma + 1, left.size()));
  }
  return hosts;
}

// The port of the server; starts one that ends when no token is open any more.
std::uint16_t serving_port(const KeyFolder& keys) {
  if (const auto port = JoinServer::running(keys)) return *port;
  run_or_fail({.command = {tims::os::find_program("timsctl"), "key", "serve", "--keys", keys.path(),
                           "--until-idle", "--detach"}});
  const auto port = JoinServer::running(keys);
  if (!port)
    throw Failure(Exit::kNo, "no_server", "timsctl key serve has ended",
                  "see " + keys.file("authority/serve.log"));
  return *port;
}

bool has_open_token(const KeyFolder& keys) {
  const auto authority = Authority::open(keys);
  if (!authority) return false;
  const auto tokens = Tokens(*authority).all();
  const std::int64_t now = wall_seconds();
  // Also a token that was used: its answer may have been lost.
  return tokens && std::ranges::any_of(*tokens, [&](const Token& one) { return now <= one.ends; });
}

// On the usual port, so that a firewall can let it through; on demand, on any.
JoinServer start_server(const KeyFolder& keys, bool on_demand) {
  auto server = JoinServer::listen(keys, security::kJoinPort);
  const bool port_in_use =
      !server && server.error() == tims::Errc::kAddressInUse && !JoinServer::running(keys);
  if (port_in_use && on_demand) server = JoinServer::listen(keys, 0);
  return key_value(std::move(server));
}

// The base renews its own certificate, as members renew theirs. A failure is tried again.
std::string renew_own(const KeyFolder& keys) {
  const auto own = keys.load();
  if (!own || !is_renewal_due(*own)) return {};
  const auto authority = Authority::open(keys);
  const auto done = authority ? authority->issue_own(own->identity, own_names(), wall_seconds())
                              : tims::Result<void>(authority.error());
  return done ? "the certificate of the base is renewed"
              : "the certificate of the base is not renewed: " + done.error().detail();
}

// For members with security.list_age_max. A failure is tried again, and their routers report it.
std::string refresh_list(const KeyFolder& keys) {
  const auto authority = Authority::open(keys);
  const auto done =
      authority ? authority->refresh_list(wall_seconds()) : tims::Result<bool>(authority.error());
  if (!done) return "the list of the fleet is not signed anew: " + done.error().detail();
  return *done ? "the list of the fleet is signed anew" : "";
}

Exit serve(Context& context, JoinServer& server, const KeyFolder& keys) {
  const tims::Time end = context.run_end();
  tims::Time look = tims::os::now() + kLookAtTokens;
  tims::Time look_at_own = tims::os::now();
  while (true) {
    const tims::Time next = std::min({end, look, server.next_timeout()});
    (void)context.signals.wait(server.descriptor(), next);
    const tims::Time now = tims::os::now();
    for (const std::string& event : server.work(now, wall_seconds()))
      context.out.write(fmt::format("{} {}\n", date_text(wall_seconds()), event));
    if (now >= end) return Exit::kDone;
    if (now >= look_at_own) {
      look_at_own = now + kLookAtOwn;
      for (const std::string& event : {renew_own(keys), refresh_list(keys)})
        if (!event.empty())
          context.out.write(fmt::format("{} {}\n", date_text(wall_seconds()), event));
    }
    if (now < look) continue;
    look = now + kLookAtTokens;
    if (context.options.until_idle && !has_open_token(keys)) return Exit::kDone;
  }
}

// An interrupted attempt may have succeeded: the token is used, and nothing is missing.
Failure join_failure(const tims::Error& error, const KeyFolder& keys) {
  Failure failure = key_failure(error);
  if (const auto own = keys.load())
    failure.hint = fmt::format("this host is {} in the fleet {} already: timsctl key show",
                               own->identity.to_string(), own->identity.fleet);
  return failure;
}

std::string state_of(const Token& token, std::int64_t now) {
  if (token.used_by) return "used";
  return now > token.ends ? "ended" : "open";
}

// During a rotation the base has a certificate of the old root still.
Certificate root_of_base(const KeyFolder& keys) {
  const auto own = key_value(keys.load());
  for (const Certificate& root : own.roots)
    if (root.has_signed(own.chain.back())) return root;
  throw Failure(Exit::kNo, "malformed",
                keys.file("identity.pem") + " comes from no root of the fleet",
                "timsctl key renew --keys " + keys.path());
}

}  // namespace

Exit token_new(Context& context) {
  const Options& options = context.options;
  const KeyFolder keys = key_folder(options);
  const Authority authority = open_authority(options);
  const Identity identity = identity_of(options, authority.fleet(), MemberRole::kSystem);
  JoinText text{.hosts = wanted_addresses(options.address),
                .port = security::kJoinPort,
                .root = {},
                .secret = {}};
  const std::int64_t now = wall_seconds();
  const auto fingerprint = root_of_base(keys).fingerprint();
  std::copy_n(fingerprint.begin(), text.root.size(), text.root.begin());
  security::fill_random(text.secret);
  const Token token{.hash = security::hash_of_secret(text.secret),
                    .identity = identity,
                    .made = now,
                    .ends = now + Tokens::kLife,
                    .used_by = {}};
  key_value(Tokens(authority).add(token, now));
  text.port = serving_port(keys);
  const std::string line = text.to_string();
  if (const auto read = JoinText::parse(line); !read) throw key_failure(read.error());
  const json::object answer{{"schema", "tims/token/1"},
                            {"text", line},
                            {"id", token.id()},
                            {"for", identity.to_string()},
                            {"ends", date_text(token.ends)}};
  context.out.write(answer, [&] { return line + "\n"; });
  context.out.note(fmt::format("token {} for {}, once, until {}: timsctl join TEXT there",
                               token.id(), identity.to_string(), date_text(token.ends)));
  return Exit::kDone;
}

Exit token_list(Context& context) {
  const Authority authority = open_authority(context.options);
  json::array items;
  for (const Token& token : key_value(Tokens(authority).all()))
    items.push_back({{"id", token.id()},
                     {"for", token.identity.to_string()},
                     {"state", state_of(token, wall_seconds())},
                     {"made", date_text(token.made)},
                     {"ends", date_text(token.ends)}});
  return show_list(context, "tims/tokens/1", std::move(items), kTokenColumns);
}

Exit token_revoke(Context& context) {
  const Authority authority = open_authority(context.options);
  for (const std::string& id : context.options.arguments) key_value(Tokens(authority).remove(id));
  return Exit::kDone;
}

Exit join(Context& context) {
  const KeyFolder keys = key_folder(context.options);
  const auto text = key_value(JoinText::parse(context.options.arguments.front()));
  const tims::Duration patience =
      context.options.has_timeout ? context.options.timeout : kJoinPatience;
  auto result = security::join_fleet(keys, text, tims::os::deadline_after(patience));
  if (!result) throw join_failure(result.error(), keys);
  const Identity joined = std::move(*result);
  context.out.note(
      fmt::format("{} in the fleet {}; keys in {}", joined.to_string(), joined.fleet, keys.path()));
  if (joined.role != MemberRole::kUser)
    context.out.note(
        fmt::format("in router.toml: [security] keys = \"{}\"; [router] role = \"{}\", "
                    "system = {}, id = {}; [[link]] kind = \"super\", to = \"{}\"",
                    keys.path(), name(joined.role), joined.system, joined.id, text.hosts.front()));
  return Exit::kDone;
}

Exit key_serve(Context& context) {
  const KeyFolder keys = key_folder(context.options);
  return run_service(context, keys.file("authority/serve.log"), "the authority is served",
                     [&](const std::function<void()>& ready) {
                       JoinServer server = start_server(keys, context.options.until_idle);
                       ready();
                       return serve(context, server, keys);
                     });
}

}  // namespace timsctl

// timsctl key init, list, show, request, sign, import, renew, revoke, rotate: keys and certificates
// (security/keys).
#include "tools/timsctl/key.h"

#include <chrono>
#include <ctime>
#include <iostream>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ifaddrs.h>
#include <net/if.h>

#include "base/text.h"
#include "os/clock.h"
#include "os/environment.h"
#include "os/file.h"
#include "os/replace_file.h"
#include "security/keys/join_client.h"
#include "security/keys/join_desk.h"
#include "tools/timsctl/command_line.h"

namespace timsctl {

using security::Authority;
using security::Certificate;
using security::Credentials;
using security::Identity;
using security::Issued;
using security::KeyFolder;
using security::MemberRole;

namespace {

constexpr std::string_view kUsualFolder = "/etc/tims/keys";
constexpr tims::Duration kKeyPatience = std::chrono::seconds(15);
constexpr std::size_t kExchangedBytesMax = security::kAnswerBytesMax;

security::Rights rights_of(const std::string& list) {
  security::Rights rights;
  std::string_view left = list;
  while (!left.empty()) {
    const std::size_t comma = std::min(left.find(','), left.size());
    const std::string_view right = base::trimmed(left.substr(0, comma));
    bool* const one = right == "look"        ? &rights.look
                      : right == "drive"     ? &rights.drive
                      : right == "configure" ? &rights.configure
                                             : nullptr;
    if (one == nullptr)
      throw usage_error(
          fmt::format("--rights: \"{}\" is not one of look, drive, configure", right));
    *one = true;
    left.remove_prefix(std::min(comma + 1, left.size()));
  }
  return rights;
}

std::string fingerprint_text(const Certificate& certificate) {
  return base::to_hex(security::View(certificate.fingerprint()).first(16));
}

json::object member_json(const Identity& identity) {
  json::object object{{"name", identity.name}, {"role", name(identity.role)}};
  if (identity.role == MemberRole::kUser) {
    json::array rights;
    if (identity.rights.look) rights.emplace_back("look");
    if (identity.rights.drive) rights.emplace_back("drive");
    if (identity.rights.configure) rights.emplace_back("configure");
    object["rights"] = std::move(rights);
  } else {
    object["system"] = identity.system;
    object["id"] = identity.id;
  }
  return object;
}

json::object certificate_json(const Certificate& certificate) {
  return {{"serial", certificate.serial()},
          {"issued", date_text(certificate.not_before() + 86400)},
          {"ends", date_text(certificate.not_after())}};
}

void merge(json::object& into, const json::object& more) {
  for (const auto& [key, value] : more) into[key] = value;
}

std::string read_exchanged(const std::string& path) {
  return value_or_fail(tims::os::read_file(path == "-" ? "/dev/stdin" : path, kExchangedBytesMax),
                       path);
}

void write_exchanged(Context& context, const std::string& path, std::string_view text) {
  if (path.empty() || path == "-") return context.out.write(text);
  value_or_fail(tims::os::replace_file(path, text), path);
}

constexpr Column kIssuedColumns[] = {
    {.title = "NAME", .path = "name"},
    {.title = "ROLE", .path = "role"},
    {.title = "SYSTEM", .path = "system", .as = Cell::kCount},
    {.title = "ID", .path = "id", .as = Cell::kCount},
    {.title = "STATE", .path = "state"},
    {.title = "ISSUED", .path = "issued"},
    {.title = "ENDS", .path = "ends"},
    {.title = "SERIAL", .path = "serial"},
    {.title = "ROOT", .path = "root", .wide = true},
};

constexpr Column kOwnLines[] = {
    {.title = "Fleet", .path = "fleet"},
    {.title = "Name", .path = "name"},
    {.title = "Role", .path = "role"},
    {.title = "System", .path = "system", .as = Cell::kCount},
    {.title = "Id", .path = "id", .as = Cell::kCount},
    {.title = "State", .path = "state"},
    {.title = "Issued", .path = "issued"},
    {.title = "Ends", .path = "ends"},
    {.title = "Serial", .path = "serial"},
    {.title = "Roots", .path = "roots"},
    {.title = "List", .path = "list", .as = Cell::kCount},
    {.title = "Made", .path = "list_made"},
    {.title = "Revoked", .path = "revoked", .as = Cell::kCount},
    {.title = "Folder", .path = "folder"},
    {.title = "Authority", .path = "authority"},
};

Failure import_failure(const tims::Error& error, bool force) {
  Failure failure = key_failure(error);
  if (error == tims::Errc::kRefused && !force)
    failure.hint = "if this host shall leave the fleet of its present keys: --force";
  return failure;
}

// The answer that `key sign` writes and `key import` reads.
void import_answer(const KeyFolder& keys, std::string_view bytes, Context& context) {
  const bool force = context.options.force;
  const auto answer = key_value(security::JoinAnswer::parse(security::view_of(bytes)));
  const auto lock = key_value(keys.lock());
  const auto taken =
      security::take_over(keys, answer, {.root = {}, .identity = {}, .another_fleet = force});
  if (!taken) throw import_failure(taken.error(), force);
  const Identity& identity = *taken;
  const Credentials own = key_value(keys.load());
  context.out.note(
      fmt::format("{} in the fleet {}, root {}: compare it with `timsctl key show` on "
                  "the base",
                  identity.to_string(), identity.fleet, fingerprint_text(own.roots.front())));
}

}  // namespace

Failure key_failure(const tims::Error& error) {
  using tims::Errc;
  switch (error.code()) {
    case Errc::kNoMailbox:
      return {Exit::kNoSuch, "no_key", error.detail()};
    case Errc::kAddressInUse:
      return {Exit::kNo, "exists", error.detail()};
    case Errc::kInvalidArgument:
      return usage_error(error.detail());
    case Errc::kTimeout:
      return {Exit::kTimeout, "timeout", error.detail()};
    case Errc::kRefused:
      return {Exit::kDenied, "refused", error.detail()};
    case Errc::kMalformed:
      return {Exit::kNo, "malformed", error.detail()};
    default:
      return failure_of(error, "");
  }
}

KeyFolder key_folder(const Options& options) {
  if (!options.keys.empty()) return KeyFolder(options.keys);
  const std::string variable = tims::os::environment("TIMS_KEYS");
  return KeyFolder(variable.empty() ? std::string(kUsualFolder) : variable);
}

Identity identity_of(const Options& options, const std::string& fleet, MemberRole usual_role) {
  Identity identity;
  identity.fleet = fleet;
  identity.role = usual_role;
  if (!options.role.empty()) {
    const auto role = security::role_of(options.role);
    if (!role)
      throw usage_error("--role: \"" + options.role + "\" is not subsystem, system, top or user");
    identity.role = *role;
  }
  const bool user = identity.role == MemberRole::kUser;
  if (user && options.name.empty()) throw usage_error("a user needs a name: --name NAME");
  if (!user && !options.rights.empty()) throw usage_error("--rights are for --role user");
  const bool needs_system =
      identity.role == MemberRole::kSystem || identity.role == MemberRole::kSubsystem;
  if (needs_system && !options.system) throw usage_error("a robot needs its number: --system N");
  if (!user) {
    identity.system = static_cast<std::uint16_t>(options.system.value_or(0));
    identity.id = static_cast<std::uint16_t>(options.id.value_or(1));
  }
  identity.rights = rights_of(options.rights);
  if (user && identity.rights == security::Rights()) identity.rights.look = true;
  identity.name = options.name.empty()
                      ? security::usual_name(identity.role, identity.system, identity.id)
                      : options.name;
  if (!security::is_name(identity.name))
    throw usage_error("--name: letters, digits, - _ . between them, at most 63");
  return identity;
}

// Addresses by which other hosts may reach this one, IPv4 before IPv6; loopback if there is nothing
// else.
std::vector<std::string> own_addresses() {
  std::vector<std::string> found;
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return {"127.0.0.1"};
  for (const int family : {AF_INET, AF_INET6}) {
    for (const ifaddrs* one = list; one != nullptr; one = one->ifa_next) {
      if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != family ||
          (one->ifa_flags & IFF_LOOPBACK) != 0 || (one->ifa_flags & IFF_UP) == 0)
        continue;
      std::array<char, INET6_ADDRSTRLEN> text{};
      const auto* six = reinterpret_cast<const sockaddr_in6*>(one->ifa_addr);
      const auto* four = reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
      if (family == AF_INET6 && IN6_IS_ADDR_LINKLOCAL(&six->sin6_addr)) continue;
      const void* bytes = family == AF_INET6 ? static_cast<const void*>(&six->sin6_addr)
                                             : static_cast<const void*>(&four->sin_addr);
      if (::inet_ntop(family, bytes, text.data(), text.size()) != nullptr)
        found.emplace_back(text.data());
    }
  }
  ::freeifaddrs(list);
  if (found.empty()) found.emplace_back("127.0.0.1");
  return found;
}

std::vector<std::string> own_names() {
  std::vector<std::string> names = own_addresses();
  names.insert(names.begin(), tims::os::host_name());
  return names;
}

bool is_renewal_due(const Credentials& own) {
  const Certificate& certificate = own.chain.front();
  return security::is_renewal_due(security::system_check_time(own.passed()),
                                  certificate.not_before(), certificate.not_after());
}

Authority open_authority(const Options& options) {
  return key_value(Authority::open(key_folder(options)));
}

std::int64_t wall_seconds() {
  return std::chrono::duration_cast<std::chrono::seconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

std::string date_text(std::int64_t seconds) {
  std::tm broken{};
  const auto time = static_cast<std::time_t>(seconds);
  if (::gmtime_r(&time, &broken) == nullptr) return "-";
  std::array<char, 40> text{};
  const std::size_t size = std::strftime(text.data(), text.size(), "%F %TZ", &broken);
  return {text.data(), size};
}

Exit key_init(Context& context) {
  const Options& options = context.options;
  const KeyFolder keys = key_folder(options);
  const std::int64_t now = wall_seconds();
  const bool exists = Authority::exists(keys);
  if (!exists && options.fleet.empty()) throw usage_error("a new fleet needs a name: --fleet NAME");
  const Authority authority =
      key_value(exists ? Authority::open(keys) : Authority::init(keys, options.fleet, now));
  if (!options.fleet.empty() && options.fleet != authority.fleet())
    throw Failure(
        Exit::kNo, "exists",
        fmt::format("{} is the authority of the fleet {}", keys.path(), authority.fleet()),
        "name another folder with --keys");
  const Identity own = identity_of(options, authority.fleet(), MemberRole::kTop);
  const auto present = keys.load();
  if (!present || present->identity != own) key_value(authority.issue_own(own, own_names(), now));
  context.out.note(fmt::format("fleet {}, root {}; this host: {}; keys in {}", authority.fleet(),
                               fingerprint_text(authority.root()), own.to_string(), keys.path()));
  context.out.note("copy " + keys.path() +
                   "/authority to a safe place: without it nobody can join");
  return Exit::kDone;
}

Exit key_list(Context& context) {
  const Authority authority = open_authority(context.options);
  const auto all = key_value(authority.issued());
  json::array items;
  for (const Issued& one : all) {
    json::object item = member_json(one.identity);
    merge(item, certificate_json(one.certificate));
    const bool present_root = [&] {
      const auto chain = authority.chain_of(one.certificate);
      return chain.size() > 1 && authority.root().has_signed(chain.back());
    }();
    const bool last = std::ranges::none_of(all, [&](const Issued& other) {
      return other.identity == one.identity && !other.revoked &&
             other.certificate.not_before() > one.certificate.not_before();
    });
    item["root"] = present_root ? "present" : "old";
    item["state"] = one.revoked    ? "revoked"
                    : !last        ? "replaced"
                    : present_root ? "valid"
                                   : "old root";
    items.push_back(std::move(item));
  }
  return show_list(context, "tims/keys/1", std::move(items), kIssuedColumns);
}

Exit key_show(Context& context) {
  const KeyFolder keys = key_folder(context.options);
  const Credentials own = key_value(keys.load());
  json::object answer{{"schema", "tims/key/1"},
                      {"fleet", own.identity.fleet},
                      {"state", security::state_of(own, security::system_check_time(own.passed()))},
                      {"list", own.list_number()},
                      {"list_made", own.list ? date_text(own.list->made) : ""},
                      {"revoked", own.list ? own.list->size() : 0},
                      {"folder", keys.path()},
                      {"authority", Authority::exists(keys)}};
  merge(answer, member_json(own.identity));
  merge(answer, certificate_json(own.chain.front()));
  std::vector<std::string> roots;
  roots.reserve(own.roots.size());
  for (const Certificate& root : own.roots) roots.push_back(fingerprint_text(root));
  answer["roots"] = fmt::format("{}", fmt::join(roots, ", "));
  context.out.write(answer, [&] { return render_page(answer, kOwnLines, context.out.look()); });
  const bool usable = answer.at("state") != "revoked" && answer.at("state") != "expired";
  return usable ? Exit::kDone : Exit::kNo;
}

Exit key_ca(Context& context) {
  const auto& arguments = context.options.arguments;
  const Credentials own = key_value(key_folder(context.options).load());
  write_exchanged(context, arguments.empty() ? "" : arguments.front(), to_pem(own.roots));
  return Exit::kDone;
}

Exit key_request(Context& context) {
  const KeyFolder keys = key_folder(context.options);
  key_value(keys.make());
  const auto key = key_value(keys.next_key());
  const auto request = key_value(security::CertificateRequest::make(key, {}));
  const auto& arguments = context.options.arguments;
  write_exchanged(context, arguments.empty() ? "" : arguments.front(), request.to_pem());
  context.out.note("carry it to the base: timsctl key sign REQUEST ANSWER --role ROLE --system N");
  return Exit::kDone;
}

Exit key_sign(Context& context) {
  const Options& options = context.options;
  const KeyFolder keys = key_folder(options);
  const auto lock = key_value(keys.lock());
  const Authority authority = open_authority(options);
  const Identity identity = identity_of(options, authority.fleet(), MemberRole::kSystem);
  const std::string pem = read_exchanged(options.arguments.front());
  const auto request = key_value(security::CertificateRequest::from_pem(pem));
  const auto list = key_value(authority.list());
  security::JoinAnswer answer;
  answer.chain = to_pem(key_value(authority.issue(identity, {}, request, wall_seconds())));
  answer.roots = to_pem(list.roots);
  answer.list = key_value(authority.list_bytes());
  write_exchanged(context, options.arguments.size() > 1 ? options.arguments[1] : "",
                  security::text_of(answer.encode()));
  context.out.note(
      fmt::format("signed for {}: carry it back, timsctl key import ANSWER", identity.to_string()));
  return Exit::kDone;
}

Exit key_import(Context& context) {
  import_answer(key_folder(context.options), read_exchanged(context.options.arguments.front()),
                context);
  return Exit::kDone;
}

Exit key_renew(Context& context) {
  const KeyFolder keys = key_folder(context.options);
  const Credentials own = key_value(keys.load());
  if (Authority::exists(keys)) {
    key_value(
        key_value(Authority::open(keys)).issue_own(own.identity, own_names(), wall_seconds()));
  } else {
    const tims::Duration patience =
        context.options.has_timeout ? context.options.timeout : kKeyPatience;
    key_value(security::renew_certificate(keys, {}, tims::os::deadline_after(patience)));
  }
  context.out.note(fmt::format("{}: renewed until {}", own.identity.to_string(),
                               date_text(key_value(keys.load()).chain.front().not_after())));
  return Exit::kDone;
}

Exit key_revoke(Context& context) {
  const Authority authority = open_authority(context.options);
  for (const std::string& name : context.options.arguments) {
    const auto revoked = key_value(authority.revoke(name, wall_seconds()));
    context.out.note(fmt::format(
        "revoked: {}, {} certificate{}; list {} of the fleet", revoked.front().identity.to_string(),
        revoked.size(), revoked.size() == 1 ? "" : "s", key_value(authority.list()).number));
  }
  return Exit::kDone;
}

Exit key_rotate(Context& context) {
  const Options& options = context.options;
  Authority authority = open_authority(options);
  if (options.finish) {
    key_value(authority.finish_rotation(options.force, wall_seconds()));
    context.out.note("only the new root is believed: " + fingerprint_text(authority.root()));
    return Exit::kDone;
  }
  key_value(authority.rotate(wall_seconds()));
  context.out.note(
      fmt::format("new root {}; members believe both roots as soon as list {} of the "
                  "fleet has reached them",
                  fingerprint_text(authority.root()), key_value(authority.list()).number));
  context.out.note(
      "routers renew their certificates within ten minutes (security.renew_within) while timsctl "
      "key serve runs here, users by timsctl key renew; when timsctl key list shows nobody with an "
      "old root, "
      "timsctl key rotate --finish");
  return Exit::kDone;
}

}  // namespace timsctl

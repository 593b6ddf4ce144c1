#include "router/io/member_keys.h"

#include <fmt/format.h>
#include <sys/stat.h>

namespace tims::io {
namespace {

constexpr std::array kFilesThatChange{"identity.pem", "fleet.pem", "revoked.list"};

security::MemberRole member_role(core::Role role) {
  switch (role) {
    case core::Role::kSubsystem:
      return security::MemberRole::kSubsystem;
    case core::Role::kSystem:
      return security::MemberRole::kSystem;
    case core::Role::kTop:
      break;
  }
  return security::MemberRole::kTop;
}

Error of_another(const security::KeyFolder& folder, const security::Identity& identity,
                 const config::Config::Router& router) {
  const bool base = folder.has("authority");
  const std::string_view role = core::name(router.role);
  return {
      Errc::kRefused,
      fmt::format("security.keys: the certificate in {} is that of {}, but this router is {} {}, "
                  "id {}: change router.role, router.system and router.id, or run {}",
                  folder.path(), identity.to_string(), role, router.system, router.id,
                  base ? fmt::format("timsctl key init --keys {} --role {} --system {} --id {}",
                                     folder.path(), role, router.system, router.id)
                       : fmt::format("timsctl token new --role {} --system {} --id {} on the "
                                     "base, and timsctl join here",
                                     role, router.system, router.id))};
}

// A list never goes back, whatever happens to the files.
void keep_newer_list(security::Credentials& read, const security::Credentials& former) {
  if (read.list_number() >= former.list_number()) return;
  read.roots = former.roots;
  read.list = former.list;
  read.list_bytes = former.list_bytes;
}

}  // namespace

MemberKeys::MemberKeys(security::KeyFolder folder, security::Credentials credentials, Stamps stamps,
                       const config::Config& config)
    : folder_(std::move(folder)),
      credentials_(std::move(credentials)),
      stamps_(stamps),
      router_(config.router),
      strictness_{.expired = config.security.refuse_expired,
                  .list_age_max = config.security.list_age_max / std::chrono::seconds(1),
                  .old_list = config.security.refuse_old_list} {}

bool MemberKeys::has_old_list() const {
  return security::is_list_old(credentials_.list.get(),
                               security::system_check_time(credentials_.passed()),
                               strictness_.list_age_max);
}

MemberKeys::Stamps MemberKeys::look(const security::KeyFolder& folder) {
  Stamps stamps;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    struct stat status {};
    if (::stat(folder.file(kFilesThatChange[i]).c_str(), &status) != 0) continue;
    stamps[i] = {status.st_ino, status.st_mtim.tv_sec * 1'000'000'000 + status.st_mtim.tv_nsec};
  }
  return stamps;
}

Result<security::Credentials> MemberKeys::read(const security::KeyFolder& folder,
                                               const config::Config::Router& router) {
  auto loaded = folder.load();
  if (!loaded) return Error(loaded.error().code(), "security.keys: " + loaded.error().detail());
  const security::Identity& identity = loaded->identity;
  if (identity.role != member_role(router.role) || identity.system != router.system ||
      identity.id != router.id)
    return of_another(folder, identity, router);
  return loaded;
}

Result<MemberKeys> MemberKeys::load(const config::Config& config) {
  security::KeyFolder folder(config.security.keys);
  const Stamps stamps = look(folder);  // before reading: a change in between is seen next time
  auto credentials = read(folder, config.router);
  if (!credentials) return credentials.error();
  return MemberKeys(std::move(folder), std::move(*credentials), stamps, config);
}

Result<bool> MemberKeys::on_timeout(Time now) {
  if (now < next_look_) return false;
  next_look_ = now + kInterval;
  const Stamps stamps = look(folder_);
  if (stamps == stamps_) return false;
  stamps_ = stamps;
  auto credentials = read(folder_, router_);
  problem_ = credentials ? "" : credentials.error().detail();
  if (!credentials) return credentials.error();
  if (credentials->identity.fleet == credentials_.identity.fleet)
    keep_newer_list(*credentials, credentials_);
  const bool changed = credentials->chain != credentials_.chain ||
                       credentials->roots != credentials_.roots ||
                       credentials->list_number() != credentials_.list_number();
  credentials_ = std::move(*credentials);
  return changed;
}

bool MemberKeys::use_list(std::shared_ptr<const security::FleetList> list,
                          const security::Bytes& bytes) {
  if (list->number <= credentials_.list_number()) return false;
  credentials_.roots = list->roots;
  credentials_.list = std::move(list);
  credentials_.list_bytes = bytes;
  return true;
}

}  // namespace tims::io

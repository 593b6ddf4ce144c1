// Folders of keys of a fleet, as timsctl key init and timsctl join make them.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "security/keys/authority.h"
#include "tests/support/temporary_folder.h"

namespace tims::test {

class FleetKeys {
 public:
  // `hosts`: names and addresses of the base in its certificate.
  explicit FleetKeys(const std::vector<std::string>& hosts = {}) {
    const security::Identity base{.fleet = "harbour",
                                  .role = security::MemberRole::kTop,
                                  .system = 0,
                                  .id = 1,
                                  .name = "base",
                                  .rights = {}};
    require(authority_.issue_own(base, hosts, seconds()));
  }

  // The setting for the router of the base.
  [[nodiscard]] std::string base() const { return setting("base"); }
  // Keys for another router; the setting for it. The same again: its certificate is renewed.
  std::string join(const std::string& name, security::MemberRole role, std::uint16_t system,
                   std::uint16_t id) {
    return join(
        {.fleet = "harbour", .role = role, .system = system, .id = id, .name = name, .rights = {}});
  }
  // Keys for a person; the folder.
  std::string user(const std::string& name, security::Rights rights) {
    join({.fleet = "harbour", .role = security::MemberRole::kUser, .name = name, .rights = rights});
    return (folder_.path() / name).string();
  }

  // In the folder of a member, as its router has stored it.
  [[nodiscard]] std::uint64_t list_number(const std::string& name) const {
    const auto loaded = security::KeyFolder((folder_.path() / name).string()).load();
    return loaded ? loaded->list_number() : 0;
  }
  // From now on nothing can be stored in the folder of a member.
  void make_unwritable(const std::string& name) const {
    const std::filesystem::path list = folder_.path() / name / "revoked.list";
    std::filesystem::remove(list);
    std::filesystem::create_directory(list);
  }
  void rotate() { require(authority_.rotate(seconds())); }
  void finish_rotation(bool force = false) {
    require(authority_.finish_rotation(force, seconds()));
  }
  void revoke(const std::string& name) { require(authority_.revoke(name, seconds())); }

 private:
  template <typename Done>
  static void require(const Done& done) {
    if (!done) throw std::runtime_error(done.error().message());
  }
  std::string join(const security::Identity& who) {
    const std::string& name = who.name;
    const security::KeyFolder keys((folder_.path() / name).string());
    require(authority_.issue_to(keys, who, {}, seconds()));
    return setting(name);
  }
  [[nodiscard]] std::string setting(const std::string& name) const {
    return "security.keys=" + (folder_.path() / name).string();
  }
  static std::int64_t seconds() {
    return std::chrono::duration_cast<std::chrono::seconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
  }

  TemporaryFolder folder_;
  security::Authority authority_ =
      security::Authority::init(security::KeyFolder((folder_.path() / "base").string()), "harbour",
                                seconds())
          .value();
};

}  // namespace tims::test

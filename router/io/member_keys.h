// The keys of this router (security.keys), as they are on the disk now: timsctl and other routers
// of this host change them while the router runs.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "router/config/config.h"
#include "security/keys/key_folder.h"
#include "tims/time.h"

namespace tims::io {

class MemberKeys {
 public:
  static constexpr Duration kInterval = std::chrono::milliseconds(250);

  // Reads the folder. The error states which command mends it: also if the certificate is that of
  // another router.
  static Result<MemberKeys> load(const config::Config& config);

  [[nodiscard]] const security::Credentials& credentials() const { return credentials_; }
  [[nodiscard]] const security::KeyFolder& folder() const { return folder_; }
  [[nodiscard]] const security::Strictness& strictness() const { return strictness_; }
  // The list is older than security.list_age_max.
  [[nodiscard]] bool has_old_list() const;
  // Why the present files cannot be used; empty: they are in force.
  [[nodiscard]] const std::string& problem() const { return problem_; }

  [[nodiscard]] Time next_timeout() const { return next_look_; }
  // Looks whether the files have changed: a few system calls. True: credentials() are new. An
  // error: what is there now cannot be used; the former credentials stay in force.
  [[nodiscard]] Result<bool> on_timeout(Time now);

  // A list of this fleet that has been verified. It counts also if it could not be stored, as long
  // as the folder has none that is as new. False: it is not newer than the present one.
  bool use_list(std::shared_ptr<const security::FleetList> list, const security::Bytes& bytes);

 private:
  struct Stamp {
    std::uint64_t inode = 0;
    std::int64_t changed_ns = 0;
    bool operator==(const Stamp&) const = default;
  };
  using Stamps = std::array<Stamp, 3>;

  MemberKeys(security::KeyFolder folder, security::Credentials credentials, Stamps stamps,
             const config::Config& config);
  static Result<security::Credentials> read(const security::KeyFolder& folder,
                                            const config::Config::Router& router);
  static Stamps look(const security::KeyFolder& folder);

  security::KeyFolder folder_;
  security::Credentials credentials_;
  Stamps stamps_;
  std::string problem_{};
  config::Config::Router router_;
  security::Strictness strictness_;
  Time next_look_{};
};

}  // namespace tims::io

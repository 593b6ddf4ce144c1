// The folder with a member's keys (`security.keys`), checked like ssh checks its own: what others
// can read or write is refused, with the command that mends it.
//
//   fleet.pem      roots that are believed
//   identity.pem   own certificate and the issuing one
//   identity.key   own private key (PKCS#8)
//   identity.key.next   the key of a certificate that is being asked for
//   revoked.list   newest list of the fleet's authority (fleet_list.h)
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "os/file.h"
#include "security/keys/credentials.h"

namespace tims::security {

class KeyFolder {
 public:
  explicit KeyFolder(std::string path) : path_(std::move(path)) {}

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string file(std::string_view name) const;

  // Makes the folder (0700) if it does not exist.
  [[nodiscard]] Result<void> make() const;
  // Until the result goes, other programs that ask for it wait: for changes of several files.
  [[nodiscard]] Result<os::File> lock() const;

  // Files of at most 2 MB, opened without following links. kNoMailbox stands for "does not exist".
  [[nodiscard]] Result<std::string> read_secret(std::string_view name) const;
  [[nodiscard]] Result<std::string> read_public(std::string_view name) const;
  [[nodiscard]] bool has(std::string_view name) const;
  // Atomic and durable.
  [[nodiscard]] Result<void> write_secret(std::string_view name, std::string_view text) const;
  [[nodiscard]] Result<void> write_public(std::string_view name, std::string_view text) const;
  [[nodiscard]] Result<void> rename(std::string_view from, std::string_view to) const;
  [[nodiscard]] Result<void> remove(std::string_view name) const;

  // All that a member needs; what does not fit together is an error. A renewal that was interrupted
  // between its two files is completed.
  [[nodiscard]] Result<Credentials> load() const;
  // The key for the next certificate: that of an interrupted attempt, or a new one.
  [[nodiscard]] Result<PrivateKey> next_key() const;
  // Takes over the certificate for the next key, with the list that came with it. Only what comes
  // from the authority that this folder believes: the list must open under the present roots, and
  // the chain lead to one of the roots of the newer list. A list that is not newer is left out.
  // kRefused otherwise; nothing has changed then.
  [[nodiscard]] Result<void> renew(const std::vector<Certificate>& chain, View list) const;
  // The same for who enters a fleet; the caller answers for `roots`. What the folder has of another
  // authority is forgotten, also its list. Empty list: none came with it.
  [[nodiscard]] Result<void> take_over(const std::vector<Certificate>& chain,
                                       const std::vector<Certificate>& roots, View list = {}) const;
  // Stores a list that is newer than the present one, and its roots. False: it is not newer.
  [[nodiscard]] Result<bool> take_over_list(View bytes) const;
  // Stores a list that the caller has opened, and its roots.
  [[nodiscard]] Result<void> write_list(View bytes, const std::vector<Certificate>& roots) const;

 private:
  [[nodiscard]] Result<os::File> open_folder() const;
  [[nodiscard]] Result<std::string> read(std::string_view name, bool secret) const;
  [[nodiscard]] Result<void> write(std::string_view name, std::string_view text, bool secret) const;
  [[nodiscard]] Result<void> forget_fleet(const std::vector<Certificate>& roots, View list) const;
  [[nodiscard]] Result<void> write_own(const std::vector<Certificate>& chain) const;
  [[nodiscard]] Result<PrivateKey> own_key(const Certificate& certificate) const;

  std::string path_;
};

}  // namespace tims::security

// The authority of a fleet: signs certificates and lists. Its keys lie in the folder "authority" of
// the base's keys, which only its user can read; routers do not need them.
//
//   root.pem root.key         signs issuing certificates only
//   issuing.pem issuing.key   signs members and lists
//   issued/SERIAL.pem         each certificate that was ever issued
//   tokens/                   who may join (tokens.h)
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "security/keys/key_folder.h"

namespace tims::security {

struct Issued {
  Certificate certificate;
  Identity identity;
  bool revoked = false;
};

class Authority {
 public:
  static constexpr int kMemberYears = 10;
  static constexpr int kRootYears = 40;

  // Makes the authority of a new fleet beside the keys in `keys`, with an empty list.
  // kAddressInUse: there is one already. `now`: seconds since 1970, here and below.
  static Result<Authority> init(const KeyFolder& keys, std::string_view fleet, std::int64_t now);
  // kNoMailbox: there is none.
  static Result<Authority> open(const KeyFolder& keys);
  [[nodiscard]] static bool exists(const KeyFolder& keys);

  [[nodiscard]] const std::string& fleet() const { return fleet_; }
  [[nodiscard]] const Certificate& root() const { return root_; }
  [[nodiscard]] const KeyFolder& folder() const { return folder_; }  // "authority" itself

  // Recorded durably before it is returned: the member's certificate and the issuing one.
  [[nodiscard]] Result<std::vector<Certificate>> issue(const Identity& identity,
                                                       const std::vector<std::string>& host_names,
                                                       const CertificateRequest& request,
                                                       std::int64_t now) const;
  // A certificate for the base itself; its key stays in `keys`.
  [[nodiscard]] Result<void> issue_own(const Identity& identity,
                                       const std::vector<std::string>& host_names,
                                       std::int64_t now) const;
  // The same for another member whose folder is on this host, with the list.
  [[nodiscard]] Result<void> issue_to(const KeyFolder& member, const Identity& identity,
                                      const std::vector<std::string>& host_names,
                                      std::int64_t now) const;
  // All certificates, the newest of a name last.
  [[nodiscard]] Result<std::vector<Issued>> issued() const;
  // The newest certificate for this key that is not revoked.
  [[nodiscard]] std::optional<Certificate> issued_for(const Digest& public_key) const;
  // The issuing certificate that belongs behind a member's.
  [[nodiscard]] std::vector<Certificate> chain_of(const Certificate& member) const;

  // The list that is in force, and its bytes.
  [[nodiscard]] Result<FleetList> list() const;
  [[nodiscard]] Result<Bytes> list_bytes() const;
  // Revokes all certificates of a name, of an identity ("system/3/1"), or with a serial number
  // (its beginning, at least 6 digits). The new list is in force when this returns. Result: what
  // was revoked; kNoMailbox: nothing fits; kInvalidArgument: several members have this name.
  [[nodiscard]] Result<std::vector<Issued>> revoke(std::string_view name, std::int64_t now) const;

  // Signs the list in force anew, with the next number, if it is a day old: so members that want to
  // know can tell whether theirs is the newest. True: there is a new one.
  static constexpr std::int64_t kListDays = 1;
  [[nodiscard]] Result<bool> refresh_list(std::int64_t now) const;
  // Replaces root and issuing key. Members believe old and new root from now on (by the list). The
  // base itself keeps its certificate of the old root: who has been away knows no other one, and
  // gets the list from it.
  [[nodiscard]] Result<void> rotate(std::int64_t now);
  // The base gets a certificate of the new root, and the old roots are believed no longer. `names`
  // of other members whose certificates come from them are an error (kRefused) unless `force`.
  [[nodiscard]] Result<void> finish_rotation(bool force, std::int64_t now) const;
  // Members that have no certificate of the present root.
  [[nodiscard]] Result<std::vector<Issued>> of_old_roots() const;

 private:
  Authority(KeyFolder keys, KeyFolder folder, Certificate root, PrivateKey root_key,
            Certificate issuing, PrivateKey issuing_key, std::string fleet);

  [[nodiscard]] Result<void> issue_to(const KeyFolder& member, const Identity& identity,
                                      const std::vector<std::string>& host_names, std::int64_t now,
                                      View list) const;
  [[nodiscard]] Result<void> put_list(const FleetList& list, const Certificate& signer,
                                      const PrivateKey& key) const;

  KeyFolder keys_;
  KeyFolder folder_;
  Certificate root_;
  PrivateKey root_key_;
  Certificate issuing_;
  PrivateKey issuing_key_;
  std::string fleet_;
};

}  // namespace tims::security

#include "security/keys/authority.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>
#include <tuple>

#include "base/text.h"

namespace tims::security {
namespace {

constexpr std::int64_t kDay = 86400;
constexpr std::int64_t kYear = 31556952;

// The files of an authority. A change of all of them is written beside them with this ending, then
// a note says that it is complete, then they are renamed: interrupted at any moment, open()
// completes it or finds the old ones.
constexpr std::array kKeyFiles{"root.key", "root.pem", "issuing.key", "issuing.pem"};
constexpr std::string_view kNext = ".next";
constexpr std::string_view kComplete = "rotation.complete";

struct Pair {
  Certificate certificate;
  PrivateKey key;
};

// A host without the right time must not issue what is not valid yet elsewhere.
Issue authority_issue(Issue::Kind kind, const std::string& fleet, std::int64_t now) {
  const bool root = kind == Issue::Kind::kRoot;
  return {.kind = kind,
          .subject = fleet + (root ? " root " : " issuing ") + std::to_string(now),
          .uris = {"tims://" + fleet + "/authority/" + (root ? "root" : "issuing")},
          .host_names = {},
          .not_before = now - kDay,
          .not_after = now + Authority::kRootYears * kYear};
}

Result<Pair> make_root(const std::string& fleet, std::int64_t now) {
  auto key = PrivateKey::generate();
  if (!key) return key.error();
  auto certificate = authority_issue(Issue::Kind::kRoot, fleet, now).self_sign(*key);
  if (!certificate) return certificate.error();
  return Pair{std::move(*certificate), std::move(*key)};
}

Result<Pair> make_issuing(const Pair& root, const std::string& fleet, std::int64_t now) {
  auto key = PrivateKey::generate();
  if (!key) return key.error();
  auto certificate =
      authority_issue(Issue::Kind::kIssuing, fleet, now).sign(*key, root.certificate, root.key);
  if (!certificate) return certificate.error();
  return Pair{std::move(*certificate), std::move(*key)};
}

Result<void> write_next(const KeyFolder& folder, const Pair& root, const Pair& issuing) {
  const std::array texts{root.key.to_pem(), root.certificate.to_pem(), issuing.key.to_pem(),
                         issuing.certificate.to_pem()};
  for (std::size_t i = 0; i < texts.size(); ++i)
    if (auto done = folder.write_secret(kKeyFiles[i] + std::string(kNext), texts[i]); !done)
      return done;
  return {};
}

Result<void> note_complete(const KeyFolder& folder) { return folder.write_secret(kComplete, ""); }

Result<void> complete_next(const KeyFolder& folder) {
  if (!folder.has(kComplete)) return {};
  for (const char* file : kKeyFiles)
    if (folder.has(file + std::string(kNext)))
      if (auto done = folder.rename(file + std::string(kNext), file); !done) return done;
  return folder.remove(kComplete);
}

Result<Pair> read_pair(const KeyFolder& folder, const std::string& name) {
  const auto certificate_text = folder.read_public(name + ".pem");
  if (!certificate_text) return certificate_text.error();
  const auto key_text = folder.read_secret(name + ".key");
  if (!key_text) return key_text.error();
  auto certificates = Certificate::from_pem(*certificate_text);
  if (!certificates)
    return Error(Errc::kMalformed,
                 folder.file(name + ".pem") + ": " + certificates.error().detail());
  auto key = PrivateKey::from_pem(*key_text);
  if (!key)
    return Error(Errc::kMalformed, folder.file(name + ".key") + ": " + key.error().detail());
  if (!certificates->front().belongs_to(*key))
    return Error(Errc::kMalformed, folder.file(name + ".key") + " does not belong to " + name +
                                       ".pem: restore both from a copy");
  return Pair{certificates->front(), std::move(*key)};
}

// The fleet in "tims://FLEET/authority/root".
std::string fleet_of(const Certificate& root) {
  constexpr std::string_view kBegin = "tims://";
  constexpr std::string_view kEnd = "/authority/root";
  for (const std::string& uri : root.uris())
    if (uri.starts_with(kBegin) && uri.ends_with(kEnd) && uri.size() > kBegin.size() + kEnd.size())
      return uri.substr(kBegin.size(), uri.size() - kBegin.size() - kEnd.size());
  return {};
}

std::string path_of(const Identity& identity) {
  if (identity.role == MemberRole::kUser) return "user/" + identity.name;
  return std::string(name(identity.role)) + "/" + std::to_string(identity.system) + "/" +
         std::to_string(identity.id);
}

bool fits(const Issued& one, std::string_view wanted) {
  return one.identity.name == wanted || path_of(one.identity) == wanted ||
         (wanted.size() >= 6 && one.certificate.serial().starts_with(wanted));
}

// A name may have been given twice; what is more exact than a name is meant as it is written.
std::optional<Error> ambiguous(const std::vector<Issued>& found, std::string_view wanted) {
  std::set<std::string> members;
  for (const Issued& one : found) {
    if (one.identity.name != wanted) return std::nullopt;
    if (!one.revoked) members.insert(path_of(one.identity));
  }
  if (members.size() < 2) return std::nullopt;
  std::string all;
  for (const std::string& member : members) all += (all.empty() ? "" : ", ") + member;
  return Error(Errc::kInvalidArgument,
               all + " have the name \"" + base::printable(wanted) +
                   "\": write which one, or the beginning of a serial number (timsctl key list)");
}

}  // namespace

Authority::Authority(KeyFolder keys, KeyFolder folder, Certificate root, PrivateKey root_key,
                     Certificate issuing, PrivateKey issuing_key, std::string fleet)
    : keys_(std::move(keys)),
      folder_(std::move(folder)),
      root_(std::move(root)),
      root_key_(std::move(root_key)),
      issuing_(std::move(issuing)),
      issuing_key_(std::move(issuing_key)),
      fleet_(std::move(fleet)) {}

bool Authority::exists(const KeyFolder& keys) {
  const KeyFolder folder(keys.file("authority"));
  return folder.has("root.pem") || folder.has(kComplete);
}

Result<Authority> Authority::init(const KeyFolder& keys, std::string_view fleet, std::int64_t now) {
  if (!is_name(fleet))
    return Error(Errc::kInvalidArgument,
                 "the fleet's name: letters, digits, - _ . between them, at most 63");
  if (auto made = keys.make(); !made) return made.error();
  const auto lock = keys.lock();
  if (!lock) return lock.error();
  if (exists(keys))
    return Error(Errc::kAddressInUse, keys.file("authority") +
                                          " exists: it is the authority of a "
                                          "fleet, and is not replaced");
  const KeyFolder folder(keys.file("authority"));
  for (const KeyFolder& made :
       {folder, KeyFolder(folder.file("issued")), KeyFolder(folder.file("tokens"))})
    if (auto done = made.make(); !done) return done.error();
  auto root = make_root(std::string(fleet), now);
  if (!root) return root.error();
  auto issuing = make_issuing(*root, std::string(fleet), now);
  if (!issuing) return issuing.error();
  if (auto done = write_next(folder, *root, *issuing); !done) return done.error();
  if (auto done = note_complete(folder); !done) return done.error();
  return open(keys);
}

Result<Authority> Authority::open(const KeyFolder& keys) {
  const KeyFolder folder(keys.file("authority"));
  if (!exists(keys))
    return Error(Errc::kNoMailbox,
                 keys.path() +
                     " has no authority: run timsctl key init on the base, or name the "
                     "base's folder with --keys");
  if (auto done = complete_next(folder); !done) return done.error();
  auto root = read_pair(folder, "root");
  if (!root) return root.error();
  auto issuing = read_pair(folder, "issuing");
  if (!issuing) return issuing.error();
  const std::string fleet = fleet_of(root->certificate);
  if (!is_name(fleet)) return Error(Errc::kMalformed, folder.file("root.pem") + " names no fleet");
  Authority authority(keys, folder, root->certificate, root->key, issuing->certificate,
                      issuing->key, fleet);
  if (!keys.has("fleet.pem"))
    if (auto done = keys.write_public("fleet.pem", root->certificate.to_pem()); !done)
      return done.error();
  if (keys.has("revoked.list")) return authority;
  FleetList first;
  first.number = 1;
  first.made = root->certificate.not_before() + kDay;
  first.fleet = fleet;
  first.roots = {root->certificate};
  if (auto done = authority.put_list(first, issuing->certificate, issuing->key); !done)
    return done.error();
  return authority;
}

Result<std::vector<Certificate>> Authority::issue(const Identity& identity,
                                                  const std::vector<std::string>& host_names,
                                                  const CertificateRequest& request,
                                                  std::int64_t now) const {
  const auto read_back = Identity::parse(identity.uris());
  if (!read_back || *read_back != identity || identity.fleet != fleet_)
    return Error(Errc::kInvalidArgument, "not an identity of the fleet " + fleet_);
  const Issue issue{.kind = Issue::Kind::kMember,
                    .subject = identity.name,
                    .uris = identity.uris(),
                    .host_names = host_names,
                    .not_before = now - kDay,
                    .not_after = now + kMemberYears * kYear};
  auto certificate = issue.sign(request, issuing_, issuing_key_);
  if (!certificate) return certificate.error();
  std::vector<Certificate> chain{*certificate, issuing_};
  const KeyFolder records(folder_.file("issued"));
  if (auto done = records.write_public(certificate->serial() + ".pem", to_pem(chain)); !done)
    return done.error();
  return chain;
}

Result<void> Authority::issue_to(const KeyFolder& member, const Identity& identity,
                                 const std::vector<std::string>& host_names, std::int64_t now,
                                 View list) const {
  const auto key = member.next_key();
  if (!key) return key.error();
  const auto request = CertificateRequest::make(*key, identity.uris());
  if (!request) return request.error();
  const auto chain = issue(identity, host_names, *request, now);
  if (!chain) return chain.error();
  const auto in_force = this->list();
  if (!in_force) return in_force.error();
  return member.take_over(*chain, in_force->roots, list);
}

Result<void> Authority::issue_own(const Identity& identity,
                                  const std::vector<std::string>& host_names,
                                  std::int64_t now) const {
  return issue_to(keys_, identity, host_names, now, {});  // the list is there
}

Result<void> Authority::issue_to(const KeyFolder& member, const Identity& identity,
                                 const std::vector<std::string>& host_names,
                                 std::int64_t now) const {
  if (auto made = member.make(); !made) return made;
  const auto list = list_bytes();
  if (!list) return list.error();
  return issue_to(member, identity, host_names, now, *list);
}

Result<std::vector<Issued>> Authority::issued() const {
  const auto in_force = list();
  if (!in_force) return in_force.error();
  const KeyFolder records(folder_.file("issued"));
  std::vector<Issued> all;
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator(records.path(), failed)) {
    if (entry.path().extension() != ".pem") continue;  // an interrupted write
    const auto text = records.read_public(entry.path().filename().string());
    if (!text) return text.error();
    const auto chain = Certificate::from_pem(*text);
    if (!chain)
      return Error(Errc::kMalformed, entry.path().string() + ": " + chain.error().detail());
    auto identity = identity_of(chain->front(), fleet_);
    if (!identity)
      return Error(Errc::kMalformed, entry.path().string() + ": " + identity.error().detail());
    all.push_back({chain->front(), std::move(*identity), in_force->revokes(chain->front())});
  }
  if (failed) return Error(Errc::kSystem, records.path() + ": " + failed.message());
  std::ranges::sort(all, {}, [](const Issued& one) {
    return std::tuple(one.identity.name, one.certificate.not_before(), one.certificate.serial());
  });
  return all;
}

std::optional<Certificate> Authority::issued_for(const Digest& public_key) const {
  const auto all = issued();
  if (!all) return std::nullopt;
  std::optional<Certificate> newest;
  for (const Issued& one : *all)
    if (!one.revoked && one.certificate.public_key_hash() == public_key &&
        (!newest || newest->not_before() < one.certificate.not_before()))
      newest = one.certificate;
  return newest;
}

std::vector<Certificate> Authority::chain_of(const Certificate& member) const {
  const KeyFolder records(folder_.file("issued"));
  const auto text = records.read_public(member.serial() + ".pem");
  if (!text) return {member};
  return Certificate::from_pem(*text).value_or({member});
}

Result<Bytes> Authority::list_bytes() const {
  const auto text = keys_.read_public("revoked.list");
  if (!text) return text.error();
  const View bytes = view_of(*text);
  return Bytes(bytes.begin(), bytes.end());
}

// That of the files: another program may have written a newer one.
Result<FleetList> Authority::list() const {
  const auto bytes = list_bytes();
  if (!bytes) return bytes.error();
  const auto roots = keys_.read_public("fleet.pem");
  if (!roots) return roots.error();
  auto believed = Certificate::from_pem(*roots);
  if (!believed) return believed.error();
  return FleetList::open(*bytes, *believed, fleet_);
}

Result<void> Authority::put_list(const FleetList& list, const Certificate& signer,
                                 const PrivateKey& key) const {
  const auto bytes = list.sign(signer, key);
  if (!bytes) return bytes.error();
  return keys_.write_list(*bytes, list.roots);
}

Result<std::vector<Issued>> Authority::revoke(std::string_view name, std::int64_t now) const {
  const auto lock = keys_.lock();
  if (!lock) return lock.error();
  auto next = list();
  if (!next) return next.error();
  const auto all = issued();
  if (!all) return all.error();
  std::vector<Issued> found;
  for (const Issued& one : *all)
    if (fits(one, name)) found.push_back(one);
  if (found.empty())
    return Error(Errc::kNoMailbox,
                 "no certificate of \"" + base::printable(name) + "\": timsctl key list shows all");
  if (auto unclear = ambiguous(found, name)) return *unclear;
  const bool news = std::ranges::any_of(found, [](const Issued& one) { return !one.revoked; });
  for (Issued& one : found) {
    next->revoke(one.certificate);
    one.revoked = true;
  }
  if (!news) return found;
  next->number += 1;
  next->made = now;
  if (auto done = put_list(*next, issuing_, issuing_key_); !done) return done.error();
  return found;
}

Result<bool> Authority::refresh_list(std::int64_t now) const {
  const auto lock = keys_.lock();
  if (!lock) return lock.error();
  auto next = list();
  if (!next) return next.error();
  if (now - next->made < kListDays * kDay) return false;
  next->number += 1;
  next->made = now;
  if (auto done = put_list(*next, issuing_, issuing_key_); !done) return done.error();
  return true;
}

// The list that makes the new root known is signed by the old authority and is in force before the
// new one issues anything. Interrupted before the note, the old authority goes on, and
// finish_rotation() forgets the new root.
Result<void> Authority::rotate(std::int64_t now) {
  const auto lock = keys_.lock();
  if (!lock) return lock.error();
  auto next = list();
  if (!next) return next.error();
  if (next->roots.size() > 1)
    return Error(Errc::kRefused,
                 "a rotation is under way: complete it with timsctl key rotate "
                 "--finish, or see who is left with timsctl key list");
  auto root = make_root(fleet_, now);
  if (!root) return root.error();
  auto issuing = make_issuing(*root, fleet_, now);
  if (!issuing) return issuing.error();
  next->roots.push_back(root->certificate);
  next->number += 1;
  next->made = now;
  if (auto done = write_next(folder_, *root, *issuing); !done) return done;
  if (auto done = put_list(*next, issuing_, issuing_key_); !done) return done;
  if (auto done = note_complete(folder_); !done) return done;
  if (auto done = complete_next(folder_); !done) return done;
  root_ = root->certificate;
  root_key_ = root->key;
  issuing_ = issuing->certificate;
  issuing_key_ = issuing->key;
  return {};
}

Result<std::vector<Issued>> Authority::of_old_roots() const {
  const auto all = issued();
  if (!all) return all.error();
  std::map<std::string, Issued> left;  // the newest one of each member
  std::set<std::string> renewed;
  for (const Issued& one : *all) {
    if (one.revoked) continue;
    if (issuing_.has_signed(one.certificate)) renewed.insert(path_of(one.identity));
    left.insert_or_assign(path_of(one.identity), one);
  }
  std::vector<Issued> old;
  for (const auto& [path, one] : left)
    if (!renewed.contains(path)) old.push_back(one);
  return old;
}

Result<void> Authority::finish_rotation(bool force, std::int64_t now) const {
  const auto lock = keys_.lock();
  if (!lock) return lock.error();
  auto next = list();
  if (!next) return next.error();
  if (next->roots.size() <= 1) return {};
  const auto left = of_old_roots();
  if (!left) return left.error();
  const auto own = keys_.load();
  std::string names;
  for (const Issued& one : *left)
    if (!own || one.identity != own->identity)
      names += (names.empty() ? "" : ", ") + one.identity.name;
  if (!names.empty() && !force)
    return Error(Errc::kRefused, names +
                                     " still have certificates of the old root, and would have "
                                     "to join again: renew them, or use --force");
  if (own && !issuing_.has_signed(own->chain.front()))
    if (auto done = issue_own(own->identity, own->chain.front().host_names(), now); !done)
      return done;
  next->roots = {root_};
  next->number += 1;
  next->made = now;
  return put_list(*next, issuing_, issuing_key_);
}

}  // namespace tims::security

#include "security/keys/key_folder.h"

#include <algorithm>
#include <array>

#include <sys/file.h>
#include <sys/stat.h>

#include "os/replace_file.h"

namespace tims::security {
namespace {

constexpr std::size_t kFileBytesMax = 2 << 20;
constexpr mode_t kOthers = S_IRWXG | S_IRWXO;
constexpr mode_t kOthersWrite = S_IWGRP | S_IWOTH;

Error refused(const std::string& path, const std::string& why, const std::string& command) {
  return {Errc::kRefused, path + " " + why + ": run " + command};
}

bool is_own(const struct stat& status) {
  return status.st_uid == ::geteuid() || status.st_uid == 0;
}

Result<std::string> content_of(const os::File& file, const std::string& path) {
  std::string content;
  std::array<char, 16 << 10> piece{};
  while (const ssize_t size = ::read(file.get(), piece.data(), piece.size())) {
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) return os::system_error(path);
    content.append(piece.data(), static_cast<std::size_t>(size));
    if (content.size() > kFileBytesMax) return Error(Errc::kTooBig, path + ": larger than 2 MB");
  }
  return content;
}

Result<void> check_file(const struct stat& status, const std::string& path, bool secret) {
  if (!S_ISREG(status.st_mode)) return Error(Errc::kRefused, path + " is not an ordinary file");
  if (!is_own(status))
    return refused(path, "belongs to another user",
                   "chown " + std::to_string(::geteuid()) + " " + path);
  if (secret && (status.st_mode & kOthers) != 0)
    return refused(path, "can be read or written by others", "chmod 600 " + path);
  if ((status.st_mode & kOthersWrite) != 0)
    return refused(path, "can be written by others", "chmod go-w " + path);
  return {};
}

std::vector<Certificate> united(std::vector<Certificate> all,
                                const std::vector<Certificate>& more) {
  for (const Certificate& one : more)
    if (std::ranges::find(all, one) == all.end()) all.push_back(one);
  return all;
}

Error of_file(const std::string& path, const Error& error) {
  return {error.code(), path + ": " + error.detail()};
}

}  // namespace

std::string KeyFolder::file(std::string_view name) const { return path_ + "/" + std::string(name); }

Result<void> KeyFolder::make() const {
  if (::mkdir(path_.c_str(), 0700) != 0 && errno != EEXIST) return os::system_error(path_);
  auto opened = open_folder();
  if (!opened) return opened.error();
  return {};
}

Result<os::File> KeyFolder::open_folder() const {
  os::File folder(::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder && errno == ENOENT)
    return Error(Errc::kNoMailbox, path_ + " does not exist: run timsctl key init or timsctl join");
  if (!folder) return os::system_error(path_);
  struct stat status {};
  if (::fstat(folder.get(), &status) != 0) return os::system_error(path_);
  if (!is_own(status))
    return refused(path_, "belongs to another user",
                   "chown -R " + std::to_string(::geteuid()) + " " + path_);
  if ((status.st_mode & kOthers) != 0)
    return refused(path_, "is open to others", "chmod 700 " + path_);
  return folder;
}

Result<os::File> KeyFolder::lock() const {
  auto folder = open_folder();
  if (!folder) return folder;
  while (::flock(folder->get(), LOCK_EX) != 0)
    if (errno != EINTR) return os::system_error(path_);
  return folder;
}

Result<std::string> KeyFolder::read(std::string_view name, bool secret) const {
  auto folder = open_folder();
  if (!folder) return folder.error();
  const std::string path = file(name);
  // Not blocking: somebody may have put a pipe there.
  const os::File opened(::openat(folder->get(), std::string(name).c_str(),
                                 O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (!opened && errno == ENOENT) return Error(Errc::kNoMailbox, path + " does not exist");
  if (!opened && errno == ELOOP)
    return refused(path, "is a symbolic link", "rm " + path + " and put the file itself there");
  if (!opened) return os::system_error(path);
  struct stat status {};
  if (::fstat(opened.get(), &status) != 0) return os::system_error(path);
  if (auto checked = check_file(status, path, secret); !checked) return checked.error();
  return content_of(opened, path);
}

Result<std::string> KeyFolder::read_secret(std::string_view name) const { return read(name, true); }
Result<std::string> KeyFolder::read_public(std::string_view name) const {
  return read(name, false);
}

bool KeyFolder::has(std::string_view name) const {
  struct stat status {};
  return ::lstat(file(name).c_str(), &status) == 0;
}

Result<void> KeyFolder::write(std::string_view name, std::string_view text, bool secret) const {
  auto folder = open_folder();
  if (!folder) return folder.error();
  const std::string path = file(name);
  struct stat status {};
  if (::fstatat(folder->get(), std::string(name).c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0) {
    if (auto checked = check_file(status, path, secret); !checked) return checked;
  } else if (errno != ENOENT) {
    return os::system_error(path);
  }
  return os::replace_file(path, text, secret ? 0600 : 0644);
}

Result<void> KeyFolder::write_secret(std::string_view name, std::string_view text) const {
  return write(name, text, true);
}
Result<void> KeyFolder::write_public(std::string_view name, std::string_view text) const {
  return write(name, text, false);
}

Result<void> KeyFolder::rename(std::string_view from, std::string_view to) const {
  if (::rename(file(from).c_str(), file(to).c_str()) != 0) return os::system_error(file(from));
  auto folder = open_folder();
  if (!folder) return folder.error();
  if (::fsync(folder->get()) != 0) return os::system_error(path_);
  return {};
}

Result<void> KeyFolder::remove(std::string_view name) const { return os::remove_file(file(name)); }

// Own key of this certificate; that of an interrupted change gets its place.
Result<PrivateKey> KeyFolder::own_key(const Certificate& certificate) const {
  const auto text = read_secret("identity.key");
  if (!text && text.error() != Errc::kNoMailbox) return text.error();
  auto key = text ? PrivateKey::from_pem(*text) : Result<PrivateKey>(text.error());
  if (key && certificate.belongs_to(*key)) return key;
  const auto next_text = read_secret("identity.key.next");
  if (next_text) {
    auto next = PrivateKey::from_pem(*next_text);
    if (next && certificate.belongs_to(*next)) {
      // A folder that cannot be written serves as it is.
      (void)rename("identity.key.next", "identity.key").ok();
      return next;
    }
  }
  if (!key) return of_file(file("identity.key"), key.error());
  return Error(Errc::kMalformed, file("identity.pem") +
                                     " does not belong to identity.key: run "
                                     "timsctl join again, or restore both");
}

Result<Credentials> KeyFolder::load() const {
  const auto read_certificates = [&](std::string_view name) -> Result<std::vector<Certificate>> {
    const auto text = read_public(name);
    if (!text) return text.error();
    auto all = Certificate::from_pem(*text);
    if (!all) return of_file(file(name), all.error());
    return all;
  };
  auto roots = read_certificates("fleet.pem");
  if (!roots) return roots.error();
  auto chain = read_certificates("identity.pem");
  if (!chain) return chain.error();
  auto identity = Identity::parse(chain->front().uris());
  if (!identity) return of_file(file("identity.pem"), identity.error());
  auto key = own_key(chain->front());
  if (!key) return key.error();
  Credentials loaded{std::move(*identity), std::move(*chain), std::move(*key),
                     std::move(*roots),    nullptr,           {}};
  const auto list = read_public("revoked.list");
  if (!list && list.error() == Errc::kNoMailbox) return loaded;
  if (!list) return list.error();
  auto opened = FleetList::open(view_of(*list), loaded.roots, loaded.identity.fleet);
  if (!opened) return of_file(file("revoked.list"), opened.error());
  loaded.roots = opened->roots;  // those of fleet.pem may be older
  loaded.list = std::make_shared<const FleetList>(std::move(*opened));
  const View bytes = view_of(*list);
  loaded.list_bytes.assign(bytes.begin(), bytes.end());
  return loaded;
}

Result<PrivateKey> KeyFolder::next_key() const {
  const auto text = read_secret("identity.key.next");
  if (text) {
    auto key = PrivateKey::from_pem(*text);
    if (key) return key;
  } else if (text.error() != Errc::kNoMailbox) {
    return text.error();
  }
  auto key = PrivateKey::generate();
  if (!key) return key;
  if (auto done = write_secret("identity.key.next", key->to_pem()); !done) return done.error();
  return key;
}

Result<void> KeyFolder::renew(const std::vector<Certificate>& chain, View list) const {
  const auto own = load();
  if (!own) return own.error();
  const auto opened = FleetList::open(list, own->roots, own->identity.fleet);
  if (!opened)
    return Error(Errc::kRefused, path_ + " believes another authority of the fleet " +
                                     own->identity.fleet + ": " + opened.error().detail());
  const bool is_newer = opened->number > own->list_number();
  if (!leads_to(is_newer ? opened->roots : own->roots, chain))
    return Error(Errc::kRefused, "the certificate comes from no root that " + path_ + " believes");
  if (is_newer)
    if (auto done = write_list(list, opened->roots); !done) return done;
  return write_own(chain);
}

Result<void> KeyFolder::take_over(const std::vector<Certificate>& chain,
                                  const std::vector<Certificate>& roots, View list) const {
  const auto own = load();
  if (own && FleetList::open(list, own->roots, own->identity.fleet).ok()) return renew(chain, list);
  const auto done =
      list.empty() ? write_public("fleet.pem", to_pem(roots)) : forget_fleet(roots, list);
  return done ? write_own(chain) : done;
}

// A reader finds the old certificate with the old key, or the new one with the next key (load()).
Result<void> KeyFolder::write_own(const std::vector<Certificate>& chain) const {
  if (auto done = write_public("identity.pem", to_pem(chain)); !done) return done;
  const auto key = own_key(chain.front());  // gives the next key its place
  return key ? Result<void>() : Result<void>(key.error());
}

Result<void> KeyFolder::forget_fleet(const std::vector<Certificate>& roots, View list) const {
  if (auto done = remove("revoked.list"); !done) return done;
  if (auto done = write_public("fleet.pem", to_pem(roots)); !done) return done;
  return write_public("revoked.list", text_of(list));
}

Result<bool> KeyFolder::take_over_list(View bytes) const {
  const auto lock = this->lock();
  if (!lock) return lock.error();
  const auto own = load();
  if (!own) return own.error();
  auto list = FleetList::open(bytes, own->roots, own->identity.fleet);
  if (!list) return list.error();
  if (list->number <= own->list_number()) return false;
  if (auto done = write_list(bytes, list->roots); !done) return done.error();
  return true;
}

// At each step fleet.pem has the root under which the list that lies there was signed.
Result<void> KeyFolder::write_list(View bytes, const std::vector<Certificate>& roots) const {
  const auto text = read_public("fleet.pem");
  if (!text) return text.error();
  const auto former = Certificate::from_pem(*text);
  if (!former) return of_file(file("fleet.pem"), former.error());
  const bool other_roots = !std::ranges::equal(roots, *former);
  if (other_roots)
    if (auto done = write_public("fleet.pem", to_pem(united(*former, roots))); !done) return done;
  if (auto done = write_public("revoked.list", text_of(bytes)); !done) return done;
  return other_roots ? write_public("fleet.pem", to_pem(roots)) : Result<void>();
}

}  // namespace tims::security

#include "router/io/http/logins.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "security/crypto/digest.h"
#include "security/crypto/handles.h"

namespace tims::io {
namespace {

constexpr std::size_t kSecretBytes = 16;

}  // namespace

// --- tokens and sessions

std::string Logins::offer(Time now, Person person) {
  return add(tokens_, kTokensMax, now + kTokenTime, std::move(person));
}

std::string Logins::begin(Time now, Person person) {
  return add(sessions_, kSessionsMax, now + kIdleTime, std::move(person));
}

std::string Logins::add(Entries& entries, std::size_t most, Time ends, Person person) {
  if (entries.size() >= most) entries.erase(std::ranges::min_element(entries, {}, &Entry::ends));
  std::array<std::byte, kSecretBytes> bytes{};
  random_(bytes);
  std::string secret;
  for (const std::byte byte : bytes) secret += fmt::format("{:02x}", std::to_integer<int>(byte));
  entries.push_back({secret, std::move(person), ends});
  return secret;
}

// Compares all of them in a time that tells nothing about a secret.
Logins::Entries::iterator Logins::find(Entries& entries, std::string_view secret, Time now) {
  std::erase_if(entries, [&](const Entry& entry) { return entry.ends <= now; });
  auto found = entries.end();
  for (auto entry = entries.begin(); entry != entries.end(); ++entry)
    if (security::equal_secretly(security::view_of(entry->secret), security::view_of(secret)))
      found = entry;
  return found;
}

std::optional<std::string> Logins::redeem(Time now, std::string_view token) {
  const auto found = find(tokens_, token, now);
  if (found == tokens_.end()) return std::nullopt;
  Person person = std::move(found->person);
  tokens_.erase(found);
  return begin(now, std::move(person));
}

const Person* Logins::use(Time now, std::string_view session) {
  const auto found = find(sessions_, session, now);
  if (found == sessions_.end()) return nullptr;
  found->ends = now + kIdleTime;
  return &found->person;
}

void Logins::end(std::string_view session) {
  std::erase_if(sessions_, [&](const Entry& entry) { return entry.secret == session; });
}

void Logins::end_if(const std::function<bool(const Person&)>& whom) {
  const auto is_his = [&](const Entry& entry) { return whom(entry.person); };
  std::erase_if(tokens_, is_his);
  std::erase_if(sessions_, is_his);
}

}  // namespace tims::io

#include "security/keys/tokens.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "base/text.h"
#include "security/keys/join_text.h"

namespace tims::security {
namespace {

constexpr std::int64_t kKeptAfterEnd = 86400;

Error damaged_token(std::string_view line) {
  return {Errc::kMalformed, "a token with the line \"" + base::printable(line) + "\""};
}

bool is_id(std::string_view text) {
  return text.size() == 8 && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::optional<Digest> digest_of(std::string_view text) {
  const auto bytes = base::parse_hex(text);
  Digest digest{};
  if (text.size() != 64 || !bytes || bytes->size() != digest.size()) return std::nullopt;
  std::ranges::copy(*bytes, digest.begin());
  return digest;
}

// One line. False: not a line of a token.
bool take_line(std::string_view key, std::string_view value, Token& token,
               std::vector<std::string>& uris) {
  if (key == "uri") return uris.emplace_back(value), true;
  if (key == "hash" || key == "used_by") {
    const auto digest = digest_of(value);
    if (!digest) return false;
    if (key == "hash")
      token.hash = *digest;
    else
      token.used_by = digest;
    return true;
  }
  const auto number = base::parse_number<std::int64_t>(value);
  if (!number || (key != "made" && key != "ends")) return false;
  (key == "made" ? token.made : token.ends) = *number;
  return true;
}

}  // namespace

std::string Token::id() const { return token_id(hash); }

std::string Token::to_string() const {
  std::string text = fmt::format("hash {}\n", base::to_hex(hash));
  for (const std::string& uri : identity.uris()) text += fmt::format("uri {}\n", uri);
  text += fmt::format("made {}\nends {}\n", made, ends);
  if (used_by) text += fmt::format("used_by {}\n", base::to_hex(*used_by));
  return text + "complete 1\n";
}

Result<Token> Token::parse(std::string_view text) {
  Token token;
  std::vector<std::string> uris;
  while (text != "complete 1\n") {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos || uris.size() > 8) return damaged_token(text.substr(0, 80));
    const std::string_view line = text.substr(0, end);
    const std::size_t blank = line.find(' ');
    if (blank == std::string_view::npos ||
        !take_line(line.substr(0, blank), line.substr(blank + 1), token, uris))
      return damaged_token(line.substr(0, 80));
    text.remove_prefix(end + 1);
  }
  auto identity = Identity::parse(uris);
  if (!identity) return identity.error();
  token.identity = std::move(*identity);
  return token;
}

Result<std::vector<Token>> Tokens::all() const {
  std::vector<Token> tokens;
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path(), failed)) {
    const std::string name = entry.path().filename().string();
    if (!is_id(name)) continue;  // an interrupted write
    auto token = find(name);
    if (token) tokens.push_back(std::move(*token));
  }
  if (failed) return Error(Errc::kSystem, folder_.path() + ": " + failed.message());
  std::ranges::sort(tokens, {}, &Token::made);
  return tokens;
}

Result<Token> Tokens::find(std::string_view id) const {
  if (!is_id(id)) return Error(Errc::kNoMailbox, "not the id of a token");
  const auto text = folder_.read_secret(id);
  if (!text) return text.error();
  auto token = Token::parse(*text);
  if (!token) return Error(Errc::kMalformed, folder_.file(id) + ": " + token.error().detail());
  return token;
}

Result<void> Tokens::add(const Token& token, std::int64_t now) const {
  const auto present = all();
  if (!present) return present.error();
  std::size_t kept = present->size();
  for (const Token& old : *present) {
    if (old.ends + kKeptAfterEnd > now) continue;
    if (auto done = folder_.remove(old.id()); !done) return done;
    --kept;
  }
  if (kept >= kTokensMax)
    return Error(Errc::kFull, "4096 tokens: revoke some with timsctl token revoke");
  return store(token);
}

Result<void> Tokens::store(const Token& token) const {
  return folder_.write_secret(token.id(), token.to_string());
}

Result<void> Tokens::remove(std::string_view id) const {
  if (!is_id(id) || !folder_.has(id))
    return Error(Errc::kNoMailbox,
                 "no token " + base::printable(id) + ": timsctl token list shows all");
  return folder_.remove(id);
}

}  // namespace tims::security

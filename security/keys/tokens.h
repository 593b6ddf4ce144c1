// Tokens at the base: who may join with which secret, once and for a while. One file each in
// authority/tokens; the secret itself is not kept.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "security/crypto/digest.h"
#include "security/keys/authority.h"
#include "security/keys/identity.h"

namespace tims::security {

struct Token {
  Digest hash{};          // hash_of_secret()
  Identity identity;      // of who joins with it
  std::int64_t made = 0;  // seconds since 1970
  std::int64_t ends = 0;
  // The public key that joined with it: this one may ask again until `ends`, if the answer was
  // lost.
  std::optional<Digest> used_by;

  [[nodiscard]] std::string id() const;
  [[nodiscard]] bool is_open(std::int64_t now) const { return now <= ends && !used_by; }

  // The text of its file, lines "KEY VALUE". Inverse of parse().
  [[nodiscard]] std::string to_string() const;
  static Result<Token> parse(std::string_view text);
  bool operator==(const Token&) const = default;
};

class Tokens {
 public:
  static constexpr std::int64_t kLife = 3600;      // seconds
  static constexpr std::size_t kTokensMax = 4096;  // files

  explicit Tokens(const Authority& authority) : folder_(authority.folder().file("tokens")) {}

  // Forgets tokens that ended a day ago. kFull: there are too many.
  [[nodiscard]] Result<void> add(const Token& token, std::int64_t now) const;
  [[nodiscard]] Result<std::vector<Token>> all() const;
  [[nodiscard]] Result<Token> find(std::string_view id) const;  // kNoMailbox: none
  [[nodiscard]] Result<void> store(const Token& token) const;
  [[nodiscard]] Result<void> remove(std::string_view id) const;  // kNoMailbox: none

 private:
  KeyFolder folder_;
};

}  // namespace tims::security

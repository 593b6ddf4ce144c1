#include "security/keys/join_text.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text.h"
#include "security/keys/bytes.h"

namespace tims::security {
namespace {

constexpr std::string_view kJoinScheme = "tims-join:";
constexpr std::string_view kDigits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
constexpr std::size_t kCodeBytes = 34;
constexpr std::size_t kHostMax = 253;

std::string base64url(View bytes) {
  std::string text;
  std::uint32_t bits = 0;
  int count = 0;
  for (const std::byte byte : bytes) {
    bits = bits << 8 | std::to_integer<std::uint32_t>(byte);
    for (count += 8; count >= 6; count -= 6) text += kDigits[bits >> (count - 6) & 63U];
  }
  if (count > 0) text += kDigits[bits << (6 - count) & 63U];
  return text;
}

// Only what base64url() makes: no other bits in the last digit.
std::optional<Bytes> from_base64url(std::string_view text) {
  Bytes bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const std::size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> count));
  }
  if ((bits & ((1U << count) - 1)) != 0) return std::nullopt;
  return bytes;
}

Bytes code_of(View root, View secret) {
  Bytes code;
  append(code, root);
  append(code, secret);
  const Digest check = sha256(code);
  append(code, View(check).first(2));
  return code;
}

bool is_host(std::string_view text) {
  return !text.empty() && text.size() <= kHostMax && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '-' || c == '_' || c == ':' || c == '%';
  });
}

Error wrong(std::string_view why) {
  return {Errc::kMalformed,
          "this text is not one to join with: " + std::string(why) +
              ". Copy all that timsctl token new has printed, from \"tims-join:\" "
              "to the end"};
}

// "10.9.1.1,[fe80::1]:2011" into hosts and port.
Result<void> parse_place(std::string_view place, JoinText& into) {
  const std::size_t colon = place.rfind(':');
  if (colon == std::string_view::npos) return wrong("it has no port");
  const auto port = base::parse_number<std::uint16_t>(place.substr(colon + 1));
  if (!port || *port == 0) return wrong("the port is no number from 1 to 65535");
  into.port = *port;
  for (std::string_view left = place.substr(0, colon);;) {
    const std::size_t comma = left.find(',');
    std::string_view host = left.substr(0, comma);
    const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
    if (bracketed) host = host.substr(1, host.size() - 2);
    if (!is_host(host) || (!bracketed && host.find(':') != std::string_view::npos))
      return wrong("the address of the base is none");
    into.hosts.emplace_back(host);
    if (into.hosts.size() > JoinText::kHostsMax) return wrong("it has more addresses than 4");
    if (comma == std::string_view::npos) return {};
    left.remove_prefix(comma + 1);
  }
}

}  // namespace

std::string JoinText::to_string() const {
  std::string place;
  for (const std::string& host : hosts) {
    if (!place.empty()) place += ',';
    place += host.find(':') == std::string::npos ? host : "[" + host + "]";
  }
  return fmt::format("{}{}:{}/{}", kJoinScheme, place, port, base64url(code_of(root, secret)));
}

Result<JoinText> JoinText::parse(std::string_view text) {
  text = base::trimmed(text, " \t\r\n");
  if (!text.starts_with(kJoinScheme)) return wrong("it must begin with \"tims-join:\"");
  text.remove_prefix(kJoinScheme.size());
  const std::size_t slash = text.rfind('/');
  if (slash == std::string_view::npos) return wrong("it is not complete");
  JoinText parsed;
  if (auto done = parse_place(text.substr(0, slash), parsed); !done) return done.error();
  const auto code = from_base64url(text.substr(slash + 1));
  if (!code || code->size() != kCodeBytes) return wrong("its code is not complete");
  const View bytes(*code);
  if (code_of(bytes.first(16), bytes.subspan(16, 16)) != *code)
    return wrong("its code has a wrong character");
  std::ranges::copy(bytes.first(16), parsed.root.begin());
  std::ranges::copy(bytes.subspan(16, 16), parsed.secret.begin());
  return parsed;
}

Digest hash_of_secret(View secret) { return sha256(secret); }

std::string token_id(const Digest& hash) { return base::to_hex(View(hash).first(4)); }

Digest join_proof(const Digest& hash, View keys) { return hmac_sha256(hash, keys); }

}  // namespace tims::security

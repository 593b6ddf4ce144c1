// What a robot and a base read before they trust anybody: the text of a token, a token's file,
// requests, answers. What is accepted is written in the same form again.
#include "security/keys/join_desk.h"
#include "security/keys/join_text.h"
#include "security/keys/tokens.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tims;
  fuzz::Input input(data, size);
  const std::string_view text = input.text();
  const security::View bytes = security::view_of(text);
  if (const auto parsed = security::JoinText::parse(text))
    fuzz::require(security::JoinText::parse(parsed->to_string()).value() == *parsed);
  if (const auto parsed = security::Token::parse(text))
    fuzz::require(security::Token::parse(parsed->to_string()).value() == *parsed);
  if (const auto parsed = security::JoinRequest::parse(bytes)) {
    const security::Bytes encoded = parsed->encode();
    fuzz::require(std::ranges::equal(encoded, bytes));
  }
  if (const auto parsed = security::JoinAnswer::parse(bytes)) {
    const auto again = security::JoinAnswer::parse(parsed->encode());
    fuzz::require(again.ok() && again->chain == parsed->chain && again->list == parsed->list);
  }
  return 0;
}

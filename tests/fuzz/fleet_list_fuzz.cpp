// Lists of a fleet. No fuzzer guesses a signature, so what it makes is signed here by an authority:
// the bytes are those before the issuing certificate. A list that is accepted is the same after
// signing it again.
#include "security/keys/bytes.h"
#include "security/keys/fleet_list.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace tims::security;

struct Signer {
  PrivateKey key = PrivateKey::generate().value();
  Certificate root = Issue{.kind = Issue::Kind::kRoot,
                           .subject = "root",
                           .uris = {},
                           .host_names = {},
                           .not_before = 0,
                           .not_after = 4'000'000'000}
                         .self_sign(key)
                         .value();
};

Bytes signed_by(const Signer& signer, View content) {
  Bytes out(content.begin(), content.end());
  append_counted<std::uint16_t>(out, signer.root.to_der());
  const Bytes signature = signer.key.sign(out).value();
  append_counted<std::uint16_t>(out, signature);
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tims;
  static const Signer signer;
  const View content = std::as_bytes(std::span(data, size));
  fuzz::use(FleetList::number_of(content));
  fuzz::require(!FleetList::open(content, {signer.root}, "harbour").ok());
  const Bytes bytes = signed_by(signer, content);
  const auto list = FleetList::open(bytes, {signer.root}, "harbour");
  if (!list) return 0;
  fuzz::require(list->number == FleetList::number_of(bytes));
  const auto again =
      FleetList::open(list->sign(signer.root, signer.key).value(), {signer.root}, "harbour");
  fuzz::require(again.ok() && again->number == list->number && again->size() == list->size() &&
                again->roots == list->roots && again->made == list->made);
  return 0;
}

// Certificates, requests and private keys of others: PEM or DER; whose identity it is, and what the
// judge says of it.
#include "security/keys/credentials.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

void look_at(const tims::security::Certificate& certificate) {
  using namespace tims;
  using namespace tims::security;
  const auto identity = Identity::parse(certificate.uris());
  if (identity) fuzz::require(Identity::parse(identity->uris()).value() == *identity);
  const auto refusal = judge(certificate, 0, {.fleet = "harbour", .name = {}, .rights = {}},
                             nullptr, {.now = 1'800'000'000, .trusted = true},
                             {.expired = true, .list_age_max = 1, .old_list = true});
  fuzz::require(refusal || (identity && identity->fleet == "harbour"));
  fuzz::use(certificate.serial());
  fuzz::use(certificate.subject());
  fuzz::use(certificate.is_authority());
  fuzz::use(certificate.is_self_signed());
  fuzz::use(certificate.has_signed(certificate));
  fuzz::use(certificate.host_names());
  FleetList list;
  list.revoke(certificate);
  fuzz::require(list.revokes(certificate));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tims;
  using namespace tims::security;
  fuzz::Input input(data, size);
  const std::string_view text = input.text();
  if (const auto one = Certificate::from_der(view_of(text))) look_at(*one);
  if (const auto all = Certificate::from_pem(text))
    for (const auto& one : *all) look_at(one);
  if (const auto request = CertificateRequest::from_pem(text)) fuzz::use(request->uris());
  fuzz::use(PrivateKey::from_pem(text).ok());
  // As the names of a certificate would be.
  std::vector<std::string> uris;
  for (std::string_view left = text; !left.empty() && uris.size() < 8;) {
    const std::size_t end = std::min(left.find('\n'), left.size());
    uris.emplace_back(left.substr(0, end));
    left.remove_prefix(std::min(end + 1, left.size()));
  }
  const auto identity = Identity::parse(uris);
  if (identity) fuzz::require(Identity::parse(identity->uris()).value() == *identity);
  return 0;
}

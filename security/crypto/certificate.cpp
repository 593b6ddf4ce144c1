#include "security/crypto/certificate.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <limits>
#include <utility>

#include <arpa/inet.h>
#include <openssl/bn.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include "security/crypto/public_key.h"

namespace tims::security {
namespace {

constexpr std::size_t kCertificateBytesMax = 16 << 10;
constexpr std::size_t kCertificatesMax = 16;

using Names = std::unique_ptr<GENERAL_NAMES, decltype(&GENERAL_NAMES_free)>;

std::vector<std::string> names_of(const GENERAL_NAMES* names, int kind) {
  std::vector<std::string> found;
  for (int i = 0; i < sk_GENERAL_NAME_num(names); ++i) {
    int type = 0;
    const void* value = GENERAL_NAME_get0_value(sk_GENERAL_NAME_value(names, i), &type);
    if (type != kind || value == nullptr) continue;
    const auto* text = static_cast<const ASN1_STRING*>(value);
    found.emplace_back(reinterpret_cast<const char*>(ASN1_STRING_get0_data(text)),
                       static_cast<std::size_t>(ASN1_STRING_length(text)));
  }
  return found;
}

std::string address_text(std::string_view bytes) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const int family = bytes.size() == sizeof(in_addr) ? AF_INET : AF_INET6;
  const bool known = bytes.size() == sizeof(in_addr) || bytes.size() == sizeof(in6_addr);
  if (!known || inet_ntop(family, bytes.data(), text.data(), text.size()) == nullptr) return {};
  return text.data();
}

// The bytes of a numeric address, IPv4 or IPv6; empty: it is none.
std::string address_bytes(const std::string& text) {
  std::array<char, sizeof(in6_addr)> bytes{};
  for (const auto& [family, size] :
       {std::pair(AF_INET, sizeof(in_addr)), std::pair(AF_INET6, sizeof(in6_addr))})
    if (inet_pton(family, text.c_str(), bytes.data()) == 1) return {bytes.data(), size};
  return {};
}

std::optional<std::int64_t> seconds_of(const ASN1_TIME* time) {
  std::tm broken{};
  if (time == nullptr || ASN1_TIME_to_tm(time, &broken) != 1) return std::nullopt;
  return static_cast<std::int64_t>(timegm(&broken));
}

// A block of a PEM text that is not what was asked for must not be skipped silently.
bool only_blanks_left(bio_st* bio) {
  const std::string left = written(bio);
  return left.find_first_not_of(" \t\r\n") == std::string::npos;
}

bool add_extension(x509_st* certificate, x509_st* issuer, int nid, const std::string& value) {
  X509V3_CTX context{};
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, nid, value.c_str());
  if (extension == nullptr) return false;
  const bool added = X509_add_ext(certificate, extension, -1) == 1;
  X509_EXTENSION_free(extension);
  return added;
}

GENERAL_NAME* general_name(int kind, const std::string& text) {
  ASN1_STRING* string = kind == GEN_IPADD ? ASN1_OCTET_STRING_new() : ASN1_IA5STRING_new();
  GENERAL_NAME* name = GENERAL_NAME_new();
  if (string == nullptr || name == nullptr ||
      ASN1_STRING_set(string, text.data(), static_cast<int>(text.size())) != 1) {
    ASN1_STRING_free(string);
    GENERAL_NAME_free(name);
    return nullptr;
  }
  GENERAL_NAME_set0_value(name, kind, string);
  return name;
}

// Built from objects, not from a configuration text, in which a comma would begin another name.
Names subject_names(const std::vector<std::string>& uris,
                    const std::vector<std::string>& host_names) {
  Names names(sk_GENERAL_NAME_new_null(), &GENERAL_NAMES_free);
  const auto add = [&](int kind, const std::string& text) {
    GENERAL_NAME* name = general_name(kind, text);
    if (name != nullptr) sk_GENERAL_NAME_push(names.get(), name);
  };
  for (const auto& uri : uris) add(GEN_URI, uri);
  for (const auto& name : host_names) {
    const std::string address = address_bytes(name);
    address.empty() ? add(GEN_DNS, name) : add(GEN_IPADD, address);
  }
  return names;
}

bool set_serial(x509_st* certificate) {
  std::array<std::byte, 16> number{};
  fill_random(number);
  number[0] = (number[0] & std::byte{0x3F}) | std::byte{0x40};  // positive, always 16 bytes
  BIGNUM* value = BN_bin2bn(reinterpret_cast<const unsigned char*>(number.data()),
                            static_cast<int>(number.size()), nullptr);
  const bool set =
      value != nullptr && BN_to_ASN1_INTEGER(value, X509_get_serialNumber(certificate)) != nullptr;
  BN_free(value);
  return set;
}

bool set_common_name(X509_NAME* name, const std::string& text) {
  return X509_NAME_add_entry_by_NID(name, NID_commonName, MBSTRING_UTF8,
                                    reinterpret_cast<const unsigned char*>(text.data()),
                                    static_cast<int>(text.size()), -1, 0) == 1;
}

bool set_uses(x509_st* certificate, x509_st* issuer, Issue::Kind kind) {
  if (kind == Issue::Kind::kMember)
    return add_extension(certificate, issuer, NID_basic_constraints, "critical,CA:FALSE") &&
           add_extension(certificate, issuer, NID_key_usage, "critical,digitalSignature") &&
           add_extension(certificate, issuer, NID_ext_key_usage, "serverAuth,clientAuth");
  const std::string length = kind == Issue::Kind::kRoot ? "1" : "0";
  return add_extension(certificate, issuer, NID_basic_constraints,
                       "critical,CA:TRUE,pathlen:" + length) &&
         add_extension(certificate, issuer, NID_key_usage, "critical,keyCertSign,cRLSign");
}

}  // namespace

Result<Certificate> Certificate::from_der(View der) {
  if (der.size() > kCertificateBytesMax)
    return Error(Errc::kTooBig, "a certificate of more than 16 kB");
  const auto* octets = reinterpret_cast<const unsigned char*>(der.data());
  const auto* const end = octets + der.size();
  Handle<x509_st> certificate(d2i_X509(nullptr, &octets, static_cast<long>(der.size())));
  if (!certificate) return crypto_error("no certificate");
  if (octets != end) return Error(Errc::kMalformed, "bytes behind a certificate");
  return Certificate(std::move(certificate));
}

Result<std::vector<Certificate>> Certificate::from_pem(std::string_view pem) {
  if (pem.size() > kCertificatesMax * kCertificateBytesMax)
    return Error(Errc::kTooBig, "more certificates than 16");
  const Handle<bio_st> bio = reading(pem);
  std::vector<Certificate> certificates;
  while (x509_st* read = PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr)) {
    certificates.push_back(Certificate(Handle<x509_st>(read)));
    if (certificates.size() > kCertificatesMax)
      return Error(Errc::kTooBig, "more certificates than 16");
  }
  // The end of a text is reported as a missing first line.
  const bool at_end = ERR_GET_REASON(ERR_peek_last_error()) == PEM_R_NO_START_LINE;
  if (certificates.empty() || !at_end || !only_blanks_left(bio.get()))
    return crypto_error("no certificates (PEM)");
  ERR_clear_error();
  return certificates;
}

Certificate Certificate::share(x509_st* certificate) {
  X509_up_ref(certificate);
  return Certificate(Handle<x509_st>(certificate));
}

std::string Certificate::to_pem() const {
  const Handle<bio_st> bio(BIO_new(BIO_s_mem()));
  PEM_write_bio_X509(bio.get(), certificate_.get());
  return written(bio.get());
}

Bytes Certificate::to_der() const {
  unsigned char* encoded = nullptr;
  const int size = i2d_X509(certificate_.get(), &encoded);
  if (size <= 0) return {};
  const auto bytes = std::as_bytes(std::span(encoded, static_cast<std::size_t>(size)));
  Bytes der(bytes.begin(), bytes.end());
  OPENSSL_free(encoded);
  return der;
}

Digest Certificate::fingerprint() const { return sha256(to_der()); }

Digest Certificate::public_key_hash() const {
  evp_pkey_st* key = X509_get0_pubkey(certificate_.get());
  return key == nullptr ? Digest{} : hash_of_public_key(key);
}

std::string Certificate::serial() const {
  BIGNUM* number = ASN1_INTEGER_to_BN(X509_get0_serialNumber(certificate_.get()), nullptr);
  char* digits = number == nullptr ? nullptr : BN_bn2hex(number);
  std::string text = digits == nullptr ? "" : digits;
  OPENSSL_free(digits);
  BN_free(number);
  std::ranges::transform(text, text.begin(), [](char c) {
    return c >= 'A' && c <= 'F' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  const std::size_t begin = text.find_first_not_of('0');
  return begin == std::string::npos ? "0" : text.substr(begin);
}

std::string Certificate::subject() const {
  const X509_NAME* name = X509_get_subject_name(certificate_.get());
  const int index = X509_NAME_get_index_by_NID(name, NID_commonName, -1);
  if (index < 0) return {};
  const ASN1_STRING* text = X509_NAME_ENTRY_get_data(X509_NAME_get_entry(name, index));
  return {reinterpret_cast<const char*>(ASN1_STRING_get0_data(text)),
          static_cast<std::size_t>(ASN1_STRING_length(text))};
}

std::vector<std::string> Certificate::names(int kind) const {
  const Names names(static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(
                        certificate_.get(), NID_subject_alt_name, nullptr, nullptr)),
                    &GENERAL_NAMES_free);
  return names ? names_of(names.get(), kind) : std::vector<std::string>();
}

std::vector<std::string> Certificate::uris() const { return names(GEN_URI); }
std::vector<std::string> Certificate::host_names() const {
  std::vector<std::string> all = names(GEN_DNS);
  for (const std::string& address : names(GEN_IPADD)) all.push_back(address_text(address));
  return all;
}

std::int64_t Certificate::not_before() const {
  return seconds_of(X509_get0_notBefore(certificate_.get()))
      .value_or(std::numeric_limits<std::int64_t>::min());
}
std::int64_t Certificate::not_after() const {
  return seconds_of(X509_get0_notAfter(certificate_.get()))
      .value_or(std::numeric_limits<std::int64_t>::max());
}

bool Certificate::is_authority() const {
  return X509_check_ca(certificate_.get()) == 1 &&
         (X509_get_key_usage(certificate_.get()) & KU_KEY_CERT_SIGN) != 0;
}

bool Certificate::is_self_signed() const { return X509_self_signed(certificate_.get(), 1) == 1; }

bool Certificate::belongs_to(const PrivateKey& key) const {
  return X509_check_private_key(certificate_.get(), key.native()) == 1;
}

bool Certificate::has_signed(const Certificate& other) const {
  evp_pkey_st* key = X509_get0_pubkey(certificate_.get());
  const bool signed_by_it = key != nullptr &&
                            X509_NAME_cmp(X509_get_subject_name(certificate_.get()),
                                          X509_get_issuer_name(other.native())) == 0 &&
                            X509_verify(other.native(), key) == 1;
  ERR_clear_error();
  return signed_by_it;
}

bool Certificate::verify(View data, View signature) const {
  evp_pkey_st* key = X509_get0_pubkey(certificate_.get());
  const bool right = key != nullptr && is_p256(key) && verify_signature(key, data, signature);
  ERR_clear_error();
  return right;
}

std::string to_pem(const std::vector<Certificate>& certificates) {
  std::string text;
  for (const Certificate& certificate : certificates) text += certificate.to_pem();
  return text;
}

Result<CertificateRequest> CertificateRequest::make(const PrivateKey& key,
                                                    const std::vector<std::string>& uris) {
  Handle<X509_req_st> request(X509_REQ_new());
  STACK_OF(X509_EXTENSION)* extensions = sk_X509_EXTENSION_new_null();
  const Names names = subject_names(uris, {});
  const bool made = request && extensions != nullptr &&
                    X509_REQ_set_version(request.get(), 0) == 1 &&
                    X509_REQ_set_pubkey(request.get(), key.native()) == 1 &&
                    X509V3_add1_i2d(&extensions, NID_subject_alt_name, names.get(), 0, 0) == 1 &&
                    X509_REQ_add_extensions(request.get(), extensions) == 1 &&
                    X509_REQ_sign(request.get(), key.native(), EVP_sha256()) != 0;
  sk_X509_EXTENSION_pop_free(extensions, X509_EXTENSION_free);
  if (!made) return crypto_error("cannot make a request for a certificate");
  return CertificateRequest(std::move(request));
}

Result<CertificateRequest> CertificateRequest::from_pem(std::string_view pem) {
  if (pem.size() > kCertificateBytesMax)
    return Error(Errc::kTooBig, "a request for a certificate of more than 16 kB");
  const Handle<bio_st> bio = reading(pem);
  Handle<X509_req_st> request(PEM_read_bio_X509_REQ(bio.get(), nullptr, nullptr, nullptr));
  if (!request) return crypto_error("no request for a certificate (PEM)");
  evp_pkey_st* key = X509_REQ_get0_pubkey(request.get());
  if (key == nullptr || !is_p256(key)) {
    ERR_clear_error();
    return Error(Errc::kMalformed, "the key of the request is not of the curve P-256");
  }
  if (X509_REQ_verify(request.get(), key) != 1)
    return crypto_error("the signature of the request is wrong");
  return CertificateRequest(std::move(request));
}

std::string CertificateRequest::to_pem() const {
  const Handle<bio_st> bio(BIO_new(BIO_s_mem()));
  PEM_write_bio_X509_REQ(bio.get(), request_.get());
  return written(bio.get());
}

std::vector<std::string> CertificateRequest::uris() const {
  STACK_OF(X509_EXTENSION)* extensions = X509_REQ_get_extensions(request_.get());
  const Names names(static_cast<GENERAL_NAMES*>(
                        X509V3_get_d2i(extensions, NID_subject_alt_name, nullptr, nullptr)),
                    &GENERAL_NAMES_free);
  sk_X509_EXTENSION_pop_free(extensions, X509_EXTENSION_free);
  return names ? names_of(names.get(), GEN_URI) : std::vector<std::string>();
}

Digest CertificateRequest::public_key_hash() const {
  return hash_of_public_key(X509_REQ_get0_pubkey(request_.get()));
}

Result<Certificate> Issue::made(evp_pkey_st* subject_key, x509_st* issuer, evp_pkey_st* key) const {
  Handle<x509_st> certificate(X509_new());
  if (!certificate) return crypto_error("cannot make a certificate");
  x509_st* const raw = certificate.get();
  x509_st* const signer = issuer == nullptr ? raw : issuer;
  const Names names = subject_names(uris, host_names);
  const bool has_names = sk_GENERAL_NAME_num(names.get()) > 0;
  const bool done =
      X509_set_version(raw, 2) == 1 && set_serial(raw) &&
      ASN1_TIME_set(X509_getm_notBefore(raw), static_cast<std::time_t>(not_before)) != nullptr &&
      ASN1_TIME_set(X509_getm_notAfter(raw), static_cast<std::time_t>(not_after)) != nullptr &&
      set_common_name(X509_get_subject_name(raw), subject) &&
      X509_set_issuer_name(raw, X509_get_subject_name(signer)) == 1 &&
      X509_set_pubkey(raw, subject_key) == 1 && set_uses(raw, signer, kind) &&
      add_extension(raw, signer, NID_subject_key_identifier, "hash") &&
      (issuer == nullptr || add_extension(raw, signer, NID_authority_key_identifier, "keyid")) &&
      (!has_names || X509_add1_ext_i2d(raw, NID_subject_alt_name, names.get(), 0, 0) == 1) &&
      X509_sign(raw, key, EVP_sha256()) != 0;
  if (!done) return crypto_error("cannot sign a certificate");
  return Certificate(std::move(certificate));
}

Result<Certificate> Issue::sign(const CertificateRequest& request, const Certificate& issuer,
                                const PrivateKey& key) const {
  return made(X509_REQ_get0_pubkey(request.native()), issuer.native(), key.native());
}

Result<Certificate> Issue::sign(const PrivateKey& subject_key, const Certificate& issuer,
                                const PrivateKey& key) const {
  return made(subject_key.native(), issuer.native(), key.native());
}

Result<Certificate> Issue::self_sign(const PrivateKey& key) const {
  return made(key.native(), nullptr, key.native());
}

}  // namespace tims::security

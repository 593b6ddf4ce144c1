#include "security/crypto/handles.h"

#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

namespace tims::security {

void Release::operator()(bio_st* object) const { BIO_free(object); }
void Release::operator()(evp_cipher_ctx_st* object) const { EVP_CIPHER_CTX_free(object); }
void Release::operator()(evp_cipher_st* object) const { EVP_CIPHER_free(object); }
void Release::operator()(evp_pkey_st* object) const { EVP_PKEY_free(object); }
void Release::operator()(ssl_ctx_st* object) const { SSL_CTX_free(object); }
void Release::operator()(ssl_st* object) const { SSL_free(object); }
void Release::operator()(x509_st* object) const { X509_free(object); }
void Release::operator()(X509_req_st* object) const { X509_REQ_free(object); }

Error crypto_error(std::string_view what) {
  const unsigned long code = ERR_get_error();
  ERR_clear_error();
  const char* reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  return {Errc::kMalformed, std::string(what) + ": " + (reason == nullptr ? "failed" : reason)};
}

}  // namespace tims::security

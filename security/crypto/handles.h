// Owners of OpenSSL's objects. Its headers are included in the sources of this folder only: what is
// compiled elsewhere sees names without content.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tims/result.h"

struct bio_st;
struct evp_cipher_ctx_st;
struct evp_cipher_st;
struct evp_pkey_st;
struct ossl_param_st;
struct ssl_ctx_st;
struct ssl_st;
struct x509_st;
struct X509_req_st;

namespace tims::security {

struct Release {
  void operator()(bio_st* object) const;
  void operator()(evp_cipher_ctx_st* object) const;
  void operator()(evp_cipher_st* object) const;
  void operator()(evp_pkey_st* object) const;
  void operator()(ssl_ctx_st* object) const;
  void operator()(ssl_st* object) const;
  void operator()(x509_st* object) const;
  void operator()(X509_req_st* object) const;
};

template <typename T>
using Handle = std::unique_ptr<T, Release>;

using Bytes = std::vector<std::byte>;
using View = std::span<const std::byte>;

// The bytes of a text.
inline View view_of(std::string_view text) { return std::as_bytes(std::span(text)); }
inline std::string_view text_of(View bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Takes OpenSSL's errors of this thread away and states the oldest one after `what`.
Error crypto_error(std::string_view what);

}  // namespace tims::security

#include "security/crypto/tls_session.h"

#include <algorithm>
#include <climits>
#include <new>

#include <openssl/err.h>
#include <openssl/ssl.h>

namespace tims::security {
namespace {

int reason_index() {
  static const int index = SSL_get_ex_new_index(0, nullptr, nullptr, nullptr, nullptr);
  return index;
}

}  // namespace

std::string* reason_of(const ssl_st* ssl) {
  return ssl == nullptr ? nullptr : static_cast<std::string*>(SSL_get_ex_data(ssl, reason_index()));
}

TlsSession::TlsSession(const TlsContext& context) : ssl_(SSL_new(context.native())) {
  in_ = BIO_new(BIO_s_mem());
  out_ = BIO_new(BIO_s_mem());
  if (!ssl_ || in_ == nullptr || out_ == nullptr) {
    BIO_free(in_);
    BIO_free(out_);
    throw std::bad_alloc();
  }
  BIO_set_mem_eof_return(in_, -1);
  BIO_set_mem_eof_return(out_, -1);
  SSL_set_bio(ssl_.get(), in_, out_);
  SSL_set_ex_data(ssl_.get(), reason_index(), &refusal_);
  if (context.side() == TlsSettings::Side::kServer)
    SSL_set_accept_state(ssl_.get());
  else
    SSL_set_connect_state(ssl_.get());
}

void TlsSession::fail() {
  state_ = State::kFailed;
  const long verified = SSL_get_verify_result(ssl_.get());
  const unsigned long code = ERR_peek_error();
  const bool about_certificate =
      ERR_GET_LIB(code) == ERR_LIB_SSL && ERR_GET_REASON(code) == SSL_R_CERTIFICATE_VERIFY_FAILED;
  if (!refusal_.empty()) {
    error_ = refusal_;
    ERR_clear_error();
  } else if (about_certificate && verified != X509_V_OK) {
    error_ = std::string("the certificate of the other side is not accepted: ") +
             X509_verify_cert_error_string(verified);
    ERR_clear_error();
  } else if (ERR_GET_LIB(code) == ERR_LIB_SSL && ERR_GET_REASON(code) > SSL_AD_REASON_OFFSET) {
    error_ = std::string("the other side refuses: ") +
             SSL_alert_desc_string_long(ERR_GET_REASON(code) - SSL_AD_REASON_OFFSET);
    ERR_clear_error();
  } else {
    error_ = crypto_error("TLS").detail();
  }
}

void TlsSession::advance() {
  if (state_ != State::kHandshake) return;
  ERR_clear_error();
  const int result = SSL_do_handshake(ssl_.get());
  if (result == 1) {
    state_ = State::kOpen;
    return;
  }
  const int reason = SSL_get_error(ssl_.get(), result);
  if (reason != SSL_ERROR_WANT_READ && reason != SSL_ERROR_WANT_WRITE) fail();
}

TlsSession::State TlsSession::feed(View bytes) {
  while (!bytes.empty()) {
    const std::size_t size = std::min<std::size_t>(bytes.size(), INT_MAX);
    BIO_write(in_, bytes.data(), static_cast<int>(size));
    bytes = bytes.subspan(size);
  }
  advance();
  return state_;
}

Bytes TlsSession::take(std::size_t room) {
  Bytes taken(std::min(room, waiting()));
  if (taken.empty()) return taken;
  const int size = BIO_read(out_, taken.data(), static_cast<int>(taken.size()));
  taken.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
  return taken;
}

std::size_t TlsSession::waiting() const { return BIO_ctrl_pending(out_); }

std::size_t TlsSession::read(std::span<std::byte> out) {
  if (state_ != State::kOpen) return 0;
  ERR_clear_error();
  std::size_t size = 0;
  const int result = SSL_read_ex(ssl_.get(), out.data(), out.size(), &size);
  if (result == 1) return size;
  const int reason = SSL_get_error(ssl_.get(), result);
  if (reason == SSL_ERROR_ZERO_RETURN)
    state_ = State::kClosed;
  else if (reason != SSL_ERROR_WANT_READ && reason != SSL_ERROR_WANT_WRITE)
    fail();
  return 0;
}

bool TlsSession::write(View data) {
  while (state_ == State::kOpen && !data.empty()) {
    ERR_clear_error();
    std::size_t size = 0;
    if (SSL_write_ex(ssl_.get(), data.data(), data.size(), &size) != 1) {
      fail();
      break;
    }
    data = data.subspan(size);
  }
  return state_ == State::kOpen;
}

void TlsSession::close() {
  if (state_ != State::kOpen) return;
  ERR_clear_error();
  SSL_shutdown(ssl_.get());
}

std::vector<Certificate> TlsSession::peer_chain() const {
  std::vector<Certificate> found;
  const STACK_OF(X509)* chain = SSL_get0_verified_chain(ssl_.get());
  found.reserve(static_cast<std::size_t>(std::max(sk_X509_num(chain), 0)));
  for (int i = 0; i < sk_X509_num(chain); ++i)
    found.push_back(Certificate::share(sk_X509_value(chain, i)));
  return found;
}

Suite TlsSession::suite() const {
  const SSL_CIPHER* cipher = SSL_get_current_cipher(ssl_.get());
  return cipher != nullptr && SSL_CIPHER_is_aead(cipher) == 1 &&
                 SSL_CIPHER_get_cipher_nid(cipher) == NID_chacha20_poly1305
             ? Suite::kChaCha20Poly1305
             : Suite::kAes128Gcm;
}

std::string_view TlsSession::version() const { return SSL_get_version(ssl_.get()); }

bool TlsSession::export_keys(std::string_view label, View context, std::span<std::byte> out) const {
  ERR_clear_error();
  return state_ == State::kOpen &&
         SSL_export_keying_material(ssl_.get(), reinterpret_cast<unsigned char*>(out.data()),
                                    out.size(), label.data(), label.size(),
                                    reinterpret_cast<const unsigned char*>(context.data()),
                                    context.size(), 1) == 1;
}

}  // namespace tims::security

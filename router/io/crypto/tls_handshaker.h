// Handshakes of links by TLS 1.3: both sides show a certificate of the fleet. They run on a thread
// of their own, because signatures take half a millisecond; the loop receives their results.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/thread_pool.hpp>

#include "router/link/seal.h"
#include "security/crypto/tls_session.h"
#include "security/keys/credentials.h"
#include "tims/result.h"

namespace tims::io {

class TlsHandshaker final : public link::Handshaker {
 public:
  // `report` is called in the other thread.
  using Report = std::function<void(link::HandshakeProgress&&)>;
  explicit TlsHandshaker(Report report);
  TlsHandshaker(const TlsHandshaker&) = delete;
  TlsHandshaker& operator=(const TlsHandshaker&) = delete;
  ~TlsHandshaker() override;

  // For handshakes that begin from now on. Before the first call none succeeds.
  Result<void> set_credentials(const security::Credentials& credentials,
                               const security::Strictness& strictness);

  void begin(std::uint64_t handshake, Side side, std::span<const std::byte> binding) override;
  void receive(std::uint64_t handshake, std::span<const std::byte> bytes) override;
  void send(std::uint64_t handshake, std::span<const std::byte> message) override;
  void end(std::uint64_t handshake) override;

 private:
  class One;     // a handshake in progress; used by the other thread only
  struct Keys {  // what a handshake begins with
    security::TlsContext connecting;
    security::TlsContext accepting;
    std::string fleet;
  };
  One* find(std::uint64_t handshake);

  Report report_;
  std::shared_ptr<const Keys> keys_;                                 // of the loop's thread
  std::vector<std::pair<std::uint64_t, std::unique_ptr<One>>> all_;  // of the other thread
  boost::asio::thread_pool thread_{1};  // the last member: it uses the others
};

}  // namespace tims::io

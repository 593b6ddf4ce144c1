#include "router/io/crypto/tls_handshaker.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <boost/asio/post.hpp>

#include "router/io/crypto/aead_sealer.h"

namespace tims::io {
namespace {

namespace asio = boost::asio;

// RFC 8446, section 7.5, as registered for private use.
constexpr std::string_view kExporterLabel = "EXPERIMENTAL-tims-link";
constexpr std::size_t kMessageMax = 1024;

std::optional<core::Role> role_of(security::MemberRole role) {
  switch (role) {
    case security::MemberRole::kSubsystem:
      return core::Role::kSubsystem;
    case security::MemberRole::kSystem:
      return core::Role::kSystem;
    case security::MemberRole::kTop:
      return core::Role::kTop;
    case security::MemberRole::kUser:
      break;
  }
  return std::nullopt;
}

}  // namespace

// Messages are records of TLS's application data: their size in two bytes, then their bytes.
class TlsHandshaker::One {
 public:
  using Side = TlsHandshaker::Side;
  One(std::uint64_t number, Side side, std::vector<std::byte> binding, const Keys& keys)
      : number_(number),
        side_(side),
        binding_(std::move(binding)),
        fleet_(keys.fleet),
        session_(side == Side::kConnects ? keys.connecting : keys.accepting) {}

  link::HandshakeProgress begin() {
    return progress_after([this] {
      if (side_ == Side::kConnects) (void)session_.feed({});
    });
  }
  link::HandshakeProgress receive(std::span<const std::byte> bytes) {
    return progress_after([&] { (void)session_.feed(bytes); });
  }
  link::HandshakeProgress send(std::span<const std::byte> message) {
    return progress_after([&] {
      waiting_.push_back(static_cast<std::byte>(message.size() & 0xFF));
      waiting_.push_back(static_cast<std::byte>(message.size() >> 8));
      waiting_.insert(waiting_.end(), message.begin(), message.end());
    });
  }

 private:
  template <typename Step>
  link::HandshakeProgress progress_after(Step step) {
    link::HandshakeProgress progress{.handshake = number_};
    step();
    using State = security::TlsSession::State;
    if (session_.state() == State::kOpen) {
      if (!verified_ && !verify(progress)) return progress;
      if (!waiting_.empty()) (void)session_.write(std::exchange(waiting_, {}));
      read(progress);
    }
    progress.to_send = session_.take(session_.waiting());
    if (session_.state() == State::kFailed) {
      progress.failure = session_.error();
      // The accepting side states the reason itself, in words.
      if (side_ == Side::kAccepts) progress.to_send.clear();
    }
    return progress;
  }

  bool verify(link::HandshakeProgress& progress) {
    const auto chain = session_.peer_chain();
    const auto identity =
        chain.empty() ? Result<security::Identity>(Error(Errc::kMalformed, "no certificate"))
                      : security::identity_of(chain.front(), fleet_);
    const auto role = identity ? role_of(identity->role) : std::nullopt;
    std::array<std::byte, 64> secrets{};
    if (!identity || !role) {
      progress.failure = identity
                             ? "the certificate of " + identity->to_string() + " is no router's"
                             : identity.error().detail();
      return false;
    }
    if (!session_.export_keys(kExporterLabel, binding_, secrets)) {
      progress.failure = "TLS gives no keys";
      return false;
    }
    AeadSealer::Secret first{};
    AeadSealer::Secret second{};
    std::ranges::copy(std::span(secrets).first(first.size()), first.begin());
    std::ranges::copy(std::span(secrets).last(second.size()), second.begin());
    const bool connects = side_ == Side::kConnects;
    progress.verified = {
        .sealer = std::make_unique<AeadSealer>(session_.suite(), connects ? first : second,
                                               connects ? second : first),
        .peer = {.role = *role,
                 .system = identity->system,
                 .id = identity->id,
                 .name = identity->name,
                 .certificate = security::Revoked::of(chain.front()).to_bytes(),
                 .issuer = chain.size() > 1 ? chain[1].to_der() : security::Bytes()}};
    for (const auto secret :
         {std::span<std::byte>(secrets), std::span<std::byte>(first), std::span<std::byte>(second)})
      security::wipe(secret);
    verified_ = true;
    return true;
  }

  void read(link::HandshakeProgress& progress) {
    std::array<std::byte, 512> bytes{};
    while (const std::size_t size = session_.read(bytes))
      in_.insert(in_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    while (in_.size() >= 2) {
      const std::size_t size =
          std::to_integer<std::size_t>(in_[0]) | std::to_integer<std::size_t>(in_[1]) << 8;
      if (size > kMessageMax) {
        progress.failure = "a message of the handshake is too long";
        return;
      }
      if (in_.size() < 2 + size) return;
      const auto end = in_.begin() + 2 + static_cast<std::ptrdiff_t>(size);
      progress.messages.emplace_back(in_.begin() + 2, end);
      in_.erase(in_.begin(), end);
    }
  }

  std::uint64_t number_;
  Side side_;
  std::vector<std::byte> binding_;
  std::string fleet_;
  security::TlsSession session_;
  bool verified_ = false;
  std::vector<std::byte> waiting_;  // to be written when TLS is open
  std::vector<std::byte> in_;       // not yet a whole message
};

TlsHandshaker::TlsHandshaker(Report report) : report_(std::move(report)) {}

TlsHandshaker::~TlsHandshaker() {
  thread_.stop();
  thread_.join();
}

Result<void> TlsHandshaker::set_credentials(const security::Credentials& credentials,
                                            const security::Strictness& strictness) {
  using Tls = security::TlsSettings::Side;
  auto connecting =
      security::TlsContext::make(security::member_settings(credentials, Tls::kClient, strictness));
  if (!connecting) return connecting.error();
  auto accepting =
      security::TlsContext::make(security::member_settings(credentials, Tls::kServer, strictness));
  if (!accepting) return accepting.error();
  keys_ = std::make_shared<const Keys>(
      Keys{std::move(*connecting), std::move(*accepting), credentials.identity.fleet});
  return {};
}

void TlsHandshaker::begin(std::uint64_t handshake, Side side, std::span<const std::byte> binding) {
  if (keys_ == nullptr) return;
  asio::post(thread_, [this, handshake, side, keys = keys_,
                       bytes = std::vector(binding.begin(), binding.end())]() mutable {
    auto one = std::make_unique<One>(handshake, side, std::move(bytes), *keys);
    auto progress = one->begin();
    all_.emplace_back(handshake, std::move(one));
    report_(std::move(progress));
  });
}

void TlsHandshaker::receive(std::uint64_t handshake, std::span<const std::byte> bytes) {
  asio::post(thread_, [this, handshake, bytes = std::vector(bytes.begin(), bytes.end())] {
    if (One* one = find(handshake)) report_(one->receive(bytes));
  });
}

void TlsHandshaker::send(std::uint64_t handshake, std::span<const std::byte> message) {
  asio::post(thread_, [this, handshake, bytes = std::vector(message.begin(), message.end())] {
    if (One* one = find(handshake)) report_(one->send(bytes));
  });
}

void TlsHandshaker::end(std::uint64_t handshake) {
  asio::post(thread_, [this, handshake] {
    std::erase_if(all_, [&](const auto& entry) { return entry.first == handshake; });
  });
}

TlsHandshaker::One* TlsHandshaker::find(std::uint64_t handshake) {
  const auto found =
      std::ranges::find(all_, handshake, [](const auto& entry) { return entry.first; });
  return found == all_.end() ? nullptr : found->second.get();
}

}  // namespace tims::io

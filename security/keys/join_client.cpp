#include "security/keys/join_client.h"

#include <functional>

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include "base/text.h"
#include "os/clock.h"
#include "os/socket.h"
#include "security/crypto/tls_session.h"
#include "security/keys/bytes.h"

namespace tims::security {
namespace {

// Where certificates are renewed: a JoinText without root and secret.
constexpr std::string_view kAuthorityFile = "authority.address";
constexpr Duration kOneAddress = std::chrono::seconds(5);

// TLS over a socket that does not block, until a deadline.
class Conversation {
 public:
  Conversation(os::File socket, const TlsContext& context, Time deadline)
      : socket_(std::move(socket)), tls_(context), deadline_(deadline) {}

  Result<TlsSession*> open() {
    tls_.feed({});
    while (tls_.state() == TlsSession::State::kHandshake)
      if (auto moved = exchange(); !moved) return moved.error();
    if (auto sent = flush(); !sent) return sent.error();
    if (tls_.state() != TlsSession::State::kOpen) return Error(Errc::kRefused, tls_.error());
    return &tls_;
  }

  Result<Bytes> ask(View request) {
    Bytes framed;
    append_counted<std::uint32_t>(framed, request);
    if (!tls_.write(framed)) return Error(Errc::kRefused, tls_.error());
    Bytes got;
    Bytes room(16 << 10);
    while (true) {
      while (const std::size_t size = tls_.read(room)) append(got, View(room).first(size));
      Reader reader(got);
      const auto size = reader.number<std::uint32_t>();
      if (reader.ok() && size > kAnswerBytesMax)
        return Error(Errc::kTooBig, "an answer of more than 1 MB");
      if (reader.ok() && reader.left().size() >= size) {
        const View answer = reader.take(size);
        return Bytes(answer.begin(), answer.end());
      }
      if (tls_.state() == TlsSession::State::kFailed) return Error(Errc::kRefused, tls_.error());
      if (tls_.state() == TlsSession::State::kClosed)
        return Error(Errc::kClosed, "the base has ended the connection without an answer");
      if (auto moved = exchange(); !moved) return moved.error();
    }
  }

 private:
  Result<void> wait_for(short events) {
    while (true) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - os::now());
      pollfd asked{.fd = socket_.get(), .events = events, .revents = 0};
      if (left.count() < 0) return Error(Errc::kTimeout, "no answer in time");
      const int ready = ::poll(&asked, 1, static_cast<int>(left.count()) + 1);
      if (ready > 0) return {};
      if (ready < 0 && errno != EINTR) return os::system_error("poll");
    }
  }

  Result<void> flush() {
    for (Bytes out = tls_.take(16 << 10); !out.empty(); out = tls_.take(16 << 10)) {
      for (View left(out); !left.empty();) {
        const ssize_t size = ::send(socket_.get(), left.data(), left.size(), MSG_NOSIGNAL);
        if (size > 0) {
          left = left.subspan(static_cast<std::size_t>(size));
        } else if (errno != EAGAIN && errno != EINTR) {
          return os::system_error("the connection");
        } else if (auto ready = wait_for(POLLOUT); !ready) {
          return ready;
        }
      }
    }
    return {};
  }

  // Sends what waits, then takes what comes.
  Result<void> exchange() {
    if (auto sent = flush(); !sent) return sent;
    if (auto ready = wait_for(POLLIN); !ready) return ready;
    std::array<std::byte, 16 << 10> room{};
    const ssize_t size = ::recv(socket_.get(), room.data(), room.size(), 0);
    if (size < 0 && errno != EAGAIN && errno != EINTR) return os::system_error("the connection");
    if (size == 0)
      return Error(Errc::kClosed,
                   "the base has ended the connection: is the address and port that "
                   "of timsctl key serve?");
    if (size > 0) tls_.feed(View(room).first(static_cast<std::size_t>(size)));
    return {};
  }

  os::File socket_;
  TlsSession tls_;
  Time deadline_;
};

using MakeRequest = std::function<Result<JoinRequest>(const TlsSession&)>;
using Accept = std::function<Result<void>(const JoinAnswer&)>;

Result<JoinAnswer> ask_one(const std::string& host, std::uint16_t port, const TlsContext& context,
                           const MakeRequest& make, const Accept& accept, Time deadline) {
  auto socket = os::connect_tcp(host, port, deadline);
  if (!socket) return socket.error();
  Conversation conversation(std::move(*socket), context, deadline);
  const auto tls = conversation.open();
  if (!tls) return tls.error();
  const auto request = make(**tls);
  if (!request) return request.error();
  const auto bytes = conversation.ask(request->encode());
  if (!bytes) return bytes.error();
  auto answer = JoinAnswer::parse(*bytes);
  if (!answer) return answer;
  if (const auto accepted = accept(*answer); !accepted) return accepted.error();
  return answer;
}

// The first answer that is accepted.
Result<JoinAnswer> ask_any(const std::vector<std::string>& hosts, std::uint16_t port,
                           const TlsContext& context, const MakeRequest& make, const Accept& accept,
                           Time deadline) {
  std::string failures;
  Errc code = Errc::kTimeout;
  for (const std::string& host : hosts) {
    auto answer =
        ask_one(host, port, context, make, accept, std::min(deadline, os::now() + kOneAddress));
    if (answer) return answer;
    code = answer.error().code();
    failures += fmt::format("{}{}:{}: {}", failures.empty() ? "" : "; ", host, port,
                            answer.error().detail());
  }
  return Error(code, failures);
}

// A user is no base. Which router is one, its role does not tell: `key init --role` chooses it. A
// member that answers for the authority all the same is found out by its answer (take_over()).
std::optional<Refusal> judge_base(const Certificate& certificate) {
  const auto identity = Identity::parse(certificate.uris());
  if (!identity) return Refusal{Refusal::Code::kIdentity, identity.error().detail()};
  if (identity->role != MemberRole::kUser) return std::nullopt;
  return Refusal{Refusal::Code::kIdentity, "the other side is a user, not the base"};
}

Result<PrivateKey> key_for(const KeyFolder& keys) {
  if (auto made = keys.make(); !made) return made.error();
  return keys.next_key();
}

std::string address_text(const JoinText& text) {
  JoinText address = text;
  address.root = {};
  address.secret = {};
  return address.to_string() + "\n";
}

}  // namespace

Result<Identity> join_fleet(const KeyFolder& keys, const JoinText& text, Time deadline) {
  const auto key = key_for(keys);
  if (!key) return key.error();
  const auto csr = CertificateRequest::make(*key, {});
  if (!csr) return csr.error();
  TlsSettings settings;
  settings.side = TlsSettings::Side::kClient;
  settings.trusted_fingerprint = text.root;
  settings.judge = [](const Certificate& certificate, int depth) {
    return depth == 0 ? judge_base(certificate) : std::nullopt;
  };
  const auto context = TlsContext::make(std::move(settings));
  if (!context) return context.error();
  const Digest hash = hash_of_secret(text.secret);
  const auto answer = ask_any(
      text.hosts, text.port, *context,
      [&](const TlsSession& tls) -> Result<JoinRequest> {
        Digest exported{};
        if (!tls.export_keys(kJoinLabel, {}, exported))
          return Error(Errc::kSystem, "TLS gives no keying material");
        return JoinRequest{.renews = false,
                           .token = token_id(hash),
                           .proof = join_proof(hash, exported),
                           .pem = csr->to_pem()};
      },
      // TLS has proven the base: its refusal would be the same at its other addresses.
      [](const JoinAnswer&) { return Result<void>(); }, deadline);
  if (!answer) return answer.error();
  const auto lock = keys.lock();
  if (!lock) return lock.error();
  auto identity =
      take_over(keys, *answer, {.root = text.root, .identity = {}, .another_fleet = true});
  if (!identity) return identity;
  if (auto done = keys.write_public(kAuthorityFile, address_text(text)); !done) return done.error();
  return identity;
}

Result<Identity> renew_certificate(const KeyFolder& keys, std::vector<std::string> hosts,
                                   Time deadline) {
  const auto own = keys.load();
  if (!own) return own.error();
  std::uint16_t port = kJoinPort;
  if (const auto written = keys.read_public(kAuthorityFile)) {
    const auto place = JoinText::parse(*written);
    if (!place) return place.error();
    port = place->port;
    hosts.insert(hosts.end(), place->hosts.begin(), place->hosts.end());
  }
  if (hosts.empty())
    return Error(Errc::kNoMailbox, keys.file(kAuthorityFile) +
                                       " does not name the base: renew with timsctl key "
                                       "request, sign and import");
  const auto key = keys.next_key();
  if (!key) return key.error();
  const auto csr = CertificateRequest::make(*key, own->identity.uris());
  if (!csr) return csr.error();
  const auto context = TlsContext::make(client_settings(*own, &judge_base));
  if (!context) return context.error();
  const auto accepted = ask_any(
      hosts, port, *context,
      [&](const TlsSession&) -> Result<JoinRequest> {
        return JoinRequest{.renews = true, .token = {}, .proof = {}, .pem = csr->to_pem()};
      },
      [&](const JoinAnswer& answer) -> Result<void> {
        const auto lock = keys.lock();
        if (!lock) return lock.error();
        const auto done = take_over(
            keys, answer, {.root = {}, .identity = own->identity, .another_fleet = false});
        return done ? Result<void>() : Result<void>(done.error());
      },
      deadline);
  if (!accepted) return accepted.error();
  return own->identity;
}

}  // namespace tims::security

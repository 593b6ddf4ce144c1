#include "router/io/tls_gate.h"

#include <utility>

#include <sys/stat.h>

#include "os/clock.h"
#include "os/file.h"

namespace tims::io {
namespace {

using security::TlsSettings;

constexpr std::size_t kFileMax = 1 << 20;

Result<std::string> read_key(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    return Error(Errc::kRefused, path + ": others can read this key: chmod 600 " + path);
  return os::read_file(path, kFileMax);
}

Error in_file(const std::string& key, const std::string& path, const Error& error) {
  return {error.code(), key + " " + path + ": " + error.detail()};
}

Result<void> add_files(TlsSettings& settings, const std::string& certificate,
                       const std::string& key) {
  const auto chain_text = os::read_file(certificate, kFileMax);
  if (!chain_text)
    return Error(chain_text.error().code(), "http.certificate: " + chain_text.error().detail());
  auto chain = security::Certificate::from_pem(*chain_text);
  if (!chain) return in_file("http.certificate", certificate, chain.error());
  const auto key_text = read_key(key);
  if (!key_text) return Error(key_text.error().code(), "http.key: " + key_text.error().detail());
  auto its_key = security::PrivateKey::from_pem(*key_text);
  if (!its_key) return in_file("http.key", key, its_key.error());
  if (!chain->front().belongs_to(*its_key))
    return Error(Errc::kRefused, "http.key " + key + " is not the key of " + certificate);
  settings.chain = std::move(*chain);
  settings.key = std::move(*its_key);
  return {};
}

}  // namespace

Result<TlsGate::Contexts> TlsGate::contexts_of(const security::Credentials& own,
                                               const security::Strictness& strictness,
                                               const std::string& certificate,
                                               const std::string& key) {
  auto members = security::TlsContext::make(
      security::member_settings(own, TlsSettings::Side::kServer, strictness));
  if (!members) return members.error();
  TlsSettings settings;
  settings.side = TlsSettings::Side::kServer;
  settings.peer = TlsSettings::PeerCertificate::kNone;
  settings.browsers = true;
  settings.chain = own.chain;
  settings.key = own.key;
  if (!certificate.empty())
    if (const auto added = add_files(settings, certificate, key); !added) return added.error();
  auto browsers = security::TlsContext::make(std::move(settings));
  if (!browsers) return browsers.error();
  return Contexts{std::move(*members), std::move(*browsers)};
}

Result<std::unique_ptr<TlsGate>> TlsGate::open(Loop& loop, LimitedLog& log, Contexts contexts) {
  auto relays = security::TlsRelays::start();
  if (!relays) return relays.error();
  return std::unique_ptr<TlsGate>(new TlsGate(loop, log, std::move(contexts), std::move(*relays)));
}

TlsGate::TlsGate(Loop& loop, LimitedLog& log, Contexts contexts,
                 std::unique_ptr<security::TlsRelays> relays)
    : loop_(loop), log_(log), contexts_(std::move(contexts)), relays_(std::move(relays)) {}

TlsGate::~TlsGate() = default;

void TlsGate::end_if(std::function<bool(const std::vector<security::Certificate>&)> which) {
  relays_->end_if([which = std::move(which)](const security::TlsRelays::Chain& chain) {
    return !chain.empty() && which(chain);
  });
}

void TlsGate::take(os::File socket, Visitor visitor, const Entrance& entrance,
                   OnConnection on_connection) {
  const bool may_be_plain = entrance.may_be_plain(visitor);
  const std::string port = entrance.kind == Kind::kTcp ? "tcp" : "http";
  auto on_refused = [this, port, peer = visitor.peer](const std::string& reason) {
    loop_.post([this, port, text = port + " " + peer + ": " + reason] {
      log_.write(os::now(), "tls " + port, config::LogLevel::kWarning, text);
    });
  };
  auto on_open = [this, visitor = std::move(visitor),
                  on_connection = std::move(on_connection)](security::Opened opened) {
    Visitor known = visitor;
    known.is_tls = opened.is_tls;
    if (!opened.chain.empty()) known.certificate = opened.chain.front();
    // A function can be copied, a file cannot.
    auto file = std::make_shared<os::File>(std::move(opened.socket));
    loop_.post([file, known = std::move(known), on_connection] {
      on_connection(std::move(*file), known);
    });
  };
  relays_->add({.socket = std::move(socket),
                .tls = entrance.kind == Kind::kTcp ? contexts_.members : contexts_.browsers,
                .may_be_plain = may_be_plain,
                .plain = {},
                .on_open = std::move(on_open),
                .on_refused = std::move(on_refused)});
}

}  // namespace tims::io

// What strangers send to a port with TLS. A stranger never gets in; of what a member has written,
// nothing arrives altered, whatever happens to its records on the way; what is not TLS is handed on
// as it came, or refused.
#include <array>
#include <optional>
#include <string>

#include <sys/socket.h>

#include "security/crypto/tls_fixture.h"
#include "security/relay/tls_relay.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace tims;
using namespace tims::security;
using fuzz::require;

constexpr std::size_t kAnswerMax = 64 << 10;

struct Fleet {
  TestPair root = test_root("fleet");
  TestPair router = test_member(root, {"tims://f/system/1/1"});
  TestPair robot = test_member(root, {"tims://f/system/2/1"});

  [[nodiscard]] TlsSettings settings(TlsSettings::Side side, const TestPair& own) const {
    TlsSettings made;
    made.side = side;
    made.chain = {own.certificate, root.certificate};
    made.key = own.key;
    made.trusted = {root.certificate};
    return made;
  }
  TlsContext members = TlsContext::make(settings(TlsSettings::Side::kServer, router)).value();
  TlsContext client = TlsContext::make(settings(TlsSettings::Side::kClient, robot)).value();
  TlsContext browsers = [this] {
    TlsSettings made = settings(TlsSettings::Side::kServer, router);
    made.peer = TlsSettings::PeerCertificate::kNone;
    made.browsers = true;
    return TlsContext::make(std::move(made)).value();
  }();
};

const Fleet& fleet() {
  static const Fleet made;
  return made;
}

// A handshake by chance is impossible.
void as_a_stranger(const TlsContext& context, View bytes, std::size_t step) {
  TlsSession server(context);
  std::size_t answered = 0;
  Bytes room(4096);
  for (View rest = bytes; !rest.empty();) {
    const View part = rest.first(std::min(step, rest.size()));
    rest = rest.subspan(part.size());
    require(server.feed(part) != TlsSession::State::kOpen);
    require(server.read(room) == 0);
    answered += server.take().size();
  }
  require(answered < kAnswerMax);
}

// Edits of the records of a member: at each position given, a byte is changed, or the rest dropped.
void as_a_member(fuzz::Input& input) {
  TlsSession client(fleet().client);
  TlsSession server(fleet().members);
  converse(client, server);
  require(server.state() == TlsSession::State::kOpen);
  const std::string text(input.number<std::uint8_t>() * 40U, 'x');
  require(client.write(view_of(text)) && client.write(view_of("end")));
  Bytes records = client.take();
  while (!input.empty() && !records.empty()) {
    const std::size_t at = input.number<std::uint16_t>() % records.size();
    const auto change = input.number<std::uint8_t>();
    if (change == 0) records.resize(at);
    if (change < records.size() - at) records[at] ^= static_cast<std::byte>(change);
  }
  server.feed(records);
  std::string arrived = read_text(server);
  require((text + "end").starts_with(arrived));
}

// By its first byte; `from_here`: it may speak in the clear.
void at_the_port(std::string_view bytes, bool from_here) {
  std::array<int, 2> ends{};
  require(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) == 0);
  const os::File outer(ends[1]);
  std::optional<Opened> opened;
  bool is_refused = false;
  Relayed what{.socket = os::File(ends[0]),
               .tls = fleet().members,
               .may_be_plain = from_here,
               .plain = {},
               .on_open = [&](Opened how) { opened = std::move(how); },
               .on_refused = [&](const std::string&) { is_refused = true; }};
  TlsRelay relay(std::move(what), Time());
  const auto sent = ::send(outer.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  require(sent == static_cast<ssize_t>(bytes.size()));
  relay.work(Time());
  const bool is_plain = !bytes.empty() && bytes.front() != '\x16';
  require(opened.has_value() == (is_plain && from_here));
  require(!(is_plain && !from_here) || is_refused);
  if (!opened) return;
  require(!opened->is_tls && opened->chain.empty());
  std::string arrived(bytes.size(), '\0');
  require(::recv(opened->socket.get(), arrived.data(), arrived.size(), 0) == sent);
  require(arrived == bytes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, std::min(size, std::size_t{32} << 10));
  const auto what = input.number<std::uint8_t>();
  const std::size_t step = input.number<std::uint8_t>() + std::size_t{1};
  switch (what % 5) {
    case 0:
      as_a_stranger(fleet().members, input.rest(), step);
      break;
    case 1:
      as_a_stranger(fleet().browsers, input.rest(), step);
      break;
    case 2:
      as_a_member(input);
      break;
    default:
      at_the_port(input.text(), what % 5 == 3);
  }
  return 0;
}

// timsctl tunnel and web: through TLS to a router; logins.
#include <iostream>

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/text.h"
#include "os/clock.h"
#include "os/environment.h"
#include "os/socket.h"
#include "os/wakeup.h"
#include "security/keys/dialled.h"
#include "security/relay/tls_relays.h"
#include "tools/cli/admin_client.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/command_line.h"
#include "tools/timsctl/key.h"
#include "wire/endpoint.h"

namespace timsctl {
namespace {

using security::TlsContext;

constexpr tims::Duration kConnectTime = std::chrono::seconds(5);
constexpr int kWaitingConnections = 64;

TcpHost tcp_host(const std::string& text) {
  const Host host = parse_host(text);
  if (const auto* tcp = std::get_if<TcpHost>(&host)) return *tcp;
  throw usage_error(fmt::format("\"{}\" is no HOST:PORT", text));
}

// HOST:PORT[/NAME], also with "tls:" before it.
TcpHost router_at(const std::string& text) {
  return tcp_host(text.starts_with("tls:") ? text : "tls:" + text);
}

// One end of the way to a router, over TLS with the keys of a folder.
class Tunnel {
 public:
  Tunnel(const Options& options, TcpHost router)
      : router_(std::move(router)),
        tls_(key_value(TlsContext::make(security::dialling_settings(
            key_value(key_folder(options).load()), {.host = router_.host, .name = router_.name})))),
        ended_(key_value(tims::os::make_event_fd())),
        relays_(key_value(security::TlsRelays::start())) {}

  // `plain`: a connected socket. Errors are printed.
  void add(tims::os::File plain) {
    auto socket = tims::os::connect_tcp(router_.host, router_.port, tims::os::now() + kConnectTime);
    if (!socket) return complain(socket.error().detail());
    relays_->add({.socket = std::move(*socket),
                  .tls = tls_,
                  .may_be_plain = false,
                  .plain = std::move(plain),
                  .on_open = [](const security::Opened&) {},
                  .on_refused = [this](const std::string& reason) { complain(reason); },
                  .on_end = [this] { tims::os::signal_event_fd(ended_.get()); }});
  }
  // Readable when a connection has ended.
  [[nodiscard]] int ended() const { return ended_.get(); }

 private:
  void complain(const std::string& reason) const {
    std::cerr << fmt::format("timsctl tunnel: {}: {}\n", tims::wire::to_string(router_),
                             base::printable(reason));
    tims::os::signal_event_fd(ended_.get());
  }

  TcpHost router_;
  TlsContext tls_;
  tims::os::File ended_;
  std::unique_ptr<security::TlsRelays> relays_;  // the last one: its thread uses the others
};

tims::os::File listen_at(const TcpHost& where) {
  const auto failure = [&](const std::string& problem) {
    return Failure(Exit::kDenied, "cannot_listen",
                   fmt::format("cannot listen on {}: {}", tims::wire::to_string(where), problem));
  };
  addrinfo wanted{};
  wanted.ai_flags = AI_PASSIVE | AI_NUMERICHOST;
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(where.host.c_str(), std::to_string(where.port).c_str(), &wanted, &found) != 0)
    throw failure("give a numeric address such as 127.0.0.1");
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
  tims::os::File file(::socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const int yes = 1;
  ::setsockopt(file.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (::bind(file.get(), found->ai_addr, found->ai_addrlen) != 0 ||
      ::listen(file.get(), kWaitingConnections) != 0)
    throw failure(tims::os::system_error("bind").detail());
  return file;
}

// For a program whose router is "tls:HOST:PORT": stdin is its end of a pair of sockets. The program
// does not wait for us: we go on in the background.
Exit serve_one(const Context& context, Tunnel& way) {
  way.add(tims::os::File(::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3)));
  (void)!::close(STDIN_FILENO);
  (void)context.signals.wait(way.ended(), tims::kNever);
  return Exit::kDone;
}

// What to open in a browser. The token is in the fragment, which browsers send to nobody.
std::string link_text(const json::object& answer, const std::string& address) {
  const std::string where = text_at(answer, "http");
  const std::size_t colon = std::min(where.rfind(':'), where.size());
  std::string host = address.empty() ? where.substr(0, colon) : address;
  if (host == "0.0.0.0" || host == "[::]") host = tims::os::host_name();
  return fmt::format("https://{}{}/#/login/{}", host, where.substr(colon),
                     text_at(answer, "token"));
}

}  // namespace

Exit tunnel(Context& context) {
  const std::vector<std::string>& arguments = context.options.arguments;
  const bool for_parent = arguments[0] == "-";
  if (for_parent) {
    const pid_t child = ::fork();
    if (child != 0) ::_exit(child > 0 ? 0 : 1);
  }
  Tunnel way(context.options, router_at(arguments[1]));
  if (for_parent) return serve_one(context, way);
  const TcpHost here = tcp_host(arguments[0]);
  const tims::os::File listener = listen_at(here);
  context.out.note(fmt::format("{} leads to {} through TLS; Ctrl-C ends it",
                               tims::wire::to_string(here), arguments[1]));
  for (;;) {
    (void)context.signals.wait(listener.get(), tims::kNever);
    tims::os::File socket(
        ::accept4(listener.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (socket) way.add(std::move(socket));
  }
}

Exit web(Context& context) {
  const Options& options = context.options;
  json::object question{{"ask", "login"}, {"bearer", options.bearer}};
  if (!options.rights.empty()) question["right"] = options.rights;
  const auto connection = context.connect();
  AdminClient router = context.admin(*connection);
  const json::object answer = router.ask(question);
  if (context.out.json()) {
    context.out.write(answer);
    return Exit::kDone;
  }
  if (options.bearer) {
    std::cout << "Authorization: Bearer " << text_at(answer, "bearer") << "\n";
    return Exit::kDone;
  }
  std::cout << link_text(answer, options.address) << "\n";
  context.out.note(fmt::format("for {}, right {}; works once, within 60 s",
                               base::printable(text_at(answer, "user")), text_at(answer, "right")));
  return Exit::kDone;
}

}  // namespace timsctl

// The pages of this port, access to them, and the answers to all other requests. Pure.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "router/io/http/console_files.h"
#include "router/io/http/http_message.h"
#include "router/io/http/logins.h"
#include "router/io/visitor.h"

namespace tims::io {

inline constexpr std::string_view kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

// The hosts and pages that may use this port: see refusal_of().
struct BrowserAccess {
  std::vector<std::string> names{};    // http.names
  std::vector<std::string> origins{};  // http.origins
  // Beyond this host, only TLS and a login are accepted; otherwise nobody is asked.
  bool login = false;
};

// Which rule a request violated.
enum class HttpRefusal : std::uint8_t { kHost, kOrigin, kCrossSite };

// As whom a request comes.
struct Entry {
  Person person{};        // without a name: nobody was asked
  std::string session{};  // empty: no login is needed, or there is none
};

struct HttpPages {
  std::function<std::string()> metrics;
  // The reason why the router is not ready for clients; empty when it is.
  std::function<std::string()> not_ready;
  // The answer to a question of the admin protocol.
  std::function<std::string(const std::string& question)> ask;
  // The rule of the policy that denies such questions to whom asks; empty: none.
  std::function<std::string(const Entry&, const Visitor&)> denied =
      [](const Entry&, const Visitor&) { return std::string(); };
  std::function<const BrowserAccess&()> access;
  // Called with the text of each refusal.
  std::function<void(HttpRefusal rule, const std::string& text)> refused;
  const ConsoleFiles* console = nullptr;  // not null
  Logins* logins = nullptr;               // not null
  std::function<Time()> now;
  // Ends the WebSockets of a session that has ended.
  std::function<void(std::string_view session)> logged_out = [](std::string_view) {};
};

// With the rights of its session, or all of them where no login is needed.
Entry entry_of(const HttpRequest& request, const Visitor& visitor, const HttpPages& pages);

// True when the request is for the WebSocket path.
bool is_for_websocket(const HttpRequest& request);
// The reason why a WebSocket request is refused; empty when the WebSocket may begin.
std::optional<HttpResponse> websocket_refusal(const HttpRequest& request, const Visitor& visitor,
                                              const HttpPages& pages);

HttpResponse answer_http(const HttpRequest& request, const Visitor& visitor,
                         const HttpPages& pages);

// --- questions

// "/api/mailboxes?match=Ladar(*%2F*)&limit=10" as a question of the admin protocol (ADMIN.md):
// {"ask":"mailboxes","match":"Ladar(*/*)","limit":10}.
//
// `query` is the part after the question mark. Empty when it contains an invalid escape. The
// admin protocol checks the question itself.
std::optional<std::string> api_question(std::string_view ask, std::string_view query);

// --- access from browsers
//
// A page of any site can make a browser send requests to this port; it cannot forge the Host,
// Origin and Sec-Fetch-Site fields. The rule: the Host is safe, and the page was served by this
// port or is listed in http.origins. Programs that are not browsers send no Origin.

struct Refused {
  HttpRefusal rule;
  std::string text;
};
std::optional<Refused> refusal_of(const HttpRequest& request, bool is_tls,
                                  const BrowserAccess& access);

// True for a Host field that is a numeric address, "localhost" or one of `names`, with or without a
// port. A site that points its own name at this machine (DNS rebinding) sends that name.
bool is_safe_host(std::string_view host, std::span<const std::string> names = {});

// True for the Origin of a page served by this port, which is exactly "https://" (`is_tls`) or
// "http://" followed by the Host field, or for one of `origins`. Pages of other ports and schemes
// are not trusted, even on this machine, because any user may serve them. Neither is "null", which
// any site can send.
bool is_safe_origin(std::string_view origin, bool is_tls, std::string_view host,
                    std::span<const std::string> origins = {});

}  // namespace tims::io

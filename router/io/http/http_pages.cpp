#include "router/io/http/http_pages.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include <arpa/inet.h>
#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <fmt/format.h>

#include "base/text.h"

namespace tims::io {
namespace {

namespace json = boost::json;

constexpr std::string_view kWebSocketPath = "/tims";
constexpr std::string_view kApiPath = "/api/";
constexpr std::string_view kJsonType = "application/json";

// Empty when the field is missing or ambiguous because it occurs more than once.
std::string_view only_field(const HttpRequest& request, std::string_view name) {
  const auto has_name = [&](const auto& field) { return equal_ignoring_case(field.name, name); };
  if (std::ranges::count_if(request.fields, has_name) != 1) return {};
  return std::ranges::find_if(request.fields, has_name)->value;
}

bool has_field(const HttpRequest& request, std::string_view name) {
  return std::ranges::any_of(
      request.fields, [&](const auto& field) { return equal_ignoring_case(field.name, name); });
}

// A prefix of the client's text, enough to identify it.
std::string quoted(std::string_view text) { return fmt::format("\"{}\"", text.substr(0, 64)); }

std::string refusal_text(std::string_view field, std::string_view value) {
  return fmt::format(
      "{} {} is refused. Browsers reach this port by a numeric address such as 127.0.0.1, by "
      "localhost or by a name in http.names, and only its own pages and those in http.origins may "
      "use it, because any web site can send requests to this machine. If it is yours, add it in "
      "the router's configuration",
      field, quoted(value));
}

std::optional<Refused> host_refusal(const HttpRequest& request, const BrowserAccess& access) {
  const std::string_view host = only_field(request, "Host");
  if (is_safe_host(host, access.names)) return std::nullopt;
  return Refused{HttpRefusal::kHost, refusal_text("host", host)};
}

HttpResponse refuse(const Refused& refused, const HttpPages& pages) {
  pages.refused(refused.rule, refused.text);
  return http_error(403, refused.text);
}

// "https://robot7:8080" moves for good: cookies and tokens are sent only there.
HttpResponse to_https(const HttpRequest& request, const HttpPages& pages) {
  if (const auto refused = host_refusal(request, pages.access())) return refuse(*refused, pages);
  HttpResponse response = http_error(308, "beyond this host, this port is reached by https://");
  response.more_fields =
      fmt::format("Location: https://{}{}\r\n", only_field(request, "Host"), request.target);
  return response;
}

bool must_use_tls(const Visitor& visitor, const BrowserAccess& access) {
  return access.login && !visitor.is_tls && !visitor.is_on_this_host();
}

HttpResponse log_in_first() {
  return http_error(401,
                    "log in first: timsctl web on a host of the fleet prints a link for browsers, "
                    "timsctl web --bearer a text for programs",
                    "WWW-Authenticate: Bearer\r\n");
}

constexpr std::string_view kLoginPath = "/login";
constexpr std::string_view kLogoutPath = "/logout";
constexpr std::string_view kCookie = "__Host-tims";
constexpr std::string_view kBearer = "Bearer ";

std::string cookie_field(std::string_view session, std::int64_t seconds) {
  return fmt::format("Set-Cookie: {}={}; Path=/; Max-Age={}; Secure; HttpOnly; SameSite=Strict\r\n",
                     kCookie, session, seconds);
}

// Empty when there is none, or more than one.
std::string_view cookie_of(const HttpRequest& request) {
  std::string_view rest = only_field(request, "Cookie");
  std::string_view found;
  int count = 0;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    std::string_view one = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    while (one.starts_with(' ')) one.remove_prefix(1);
    if (!one.starts_with(kCookie) || one.substr(kCookie.size(), 1) != "=") continue;
    found = one.substr(kCookie.size() + 1);
    ++count;
  }
  return count == 1 ? found : std::string_view();
}

std::string_view bearer_of(const HttpRequest& request) {
  const std::string_view field = only_field(request, "Authorization");
  return field.starts_with(kBearer) ? field.substr(kBearer.size()) : std::string_view();
}

// A browser names the page with everything but reading; a program has its Bearer.
bool lacks_origin(const HttpRequest& request, const Visitor& visitor, const BrowserAccess& access) {
  return access.login && visitor.is_tls && !has_field(request, "Origin") &&
         bearer_of(request).empty();
}

std::optional<Refused> acting_refusal(const HttpRequest& request, const Visitor& visitor,
                                      const HttpPages& pages) {
  if (auto refused = refusal_of(request, visitor.is_tls, pages.access())) return refused;
  if (!lacks_origin(request, visitor, pages.access())) return std::nullopt;
  return Refused{HttpRefusal::kOrigin, refusal_text("origin", "")};
}

HttpResponse answer_api(const HttpRequest& request, const Visitor& visitor,
                        const HttpPages& pages) {
  if (const auto refused = refusal_of(request, visitor.is_tls, pages.access()))
    return refuse(*refused, pages);
  const Entry entry = entry_of(request, visitor, pages);
  if (!has(entry.person.rights, Right::kLook)) return log_in_first();
  if (const std::string rule = pages.denied(entry, visitor); !rule.empty())
    return http_error(403, "the policy does not permit it: " + rule);
  const auto question = api_question(request.path().substr(kApiPath.size()), request.query());
  if (!question) return http_error(400, "broken %XX escape in " + quoted(request.target));
  std::string answer = pages.ask(*question);
  const bool is_error = answer.starts_with(R"({"error")");
  return {.status = is_error ? 400 : 200, .type = kJsonType, .body = std::move(answer) + "\n"};
}

HttpResponse answer_ready(const HttpPages& pages) {
  const std::string reason = pages.not_ready();
  return reason.empty() ? HttpResponse{.body = "ready\n"} : http_error(503, reason);
}

// Any page may link to the console.
HttpResponse answer_console(const HttpRequest& request, const HttpPages& pages) {
  if (const auto refused = host_refusal(request, pages.access())) return refuse(*refused, pages);
  return pages.console->answer(request);
}

HttpResponse login_state(const Person& person) {
  const json::object state{{"schema", "tims/login/1"},
                           {"user", base::valid_utf8(person.name)},
                           {"right", name(highest(person.rights))}};
  return {.type = kJsonType, .body = json::serialize(state) + "\n"};
}

std::string token_of(std::string_view body) {
  boost::system::error_code error;
  const json::value value = json::parse(body, error);
  const json::object* object = error ? nullptr : value.if_object();
  const json::value* token = object == nullptr ? nullptr : object->if_contains("token");
  const json::string* text = token == nullptr ? nullptr : token->if_string();
  return text == nullptr ? std::string() : std::string(*text);
}

HttpResponse log_in(const HttpRequest& request, const Visitor& visitor, const HttpPages& pages) {
  if (const auto refused = acting_refusal(request, visitor, pages)) return refuse(*refused, pages);
  const Time now = pages.now();
  const auto session = pages.logins->redeem(now, token_of(request.body));
  if (!session)
    return http_error(401,
                      "this link has been used or is older than 60 s: timsctl web prints a "
                      "new one");
  HttpResponse response = login_state(*pages.logins->use(now, *session));
  response.more_fields = cookie_field(
      *session, std::chrono::duration_cast<std::chrono::seconds>(Logins::kIdleTime).count());
  return response;
}

HttpResponse log_out(const HttpRequest& request, const Visitor& visitor, const HttpPages& pages) {
  if (const auto refused = acting_refusal(request, visitor, pages)) return refuse(*refused, pages);
  const Entry entry = entry_of(request, visitor, pages);
  if (!entry.session.empty()) {
    pages.logins->end(entry.session);
    pages.logged_out(entry.session);
  }
  HttpResponse response = login_state({});
  response.more_fields = cookie_field("", 0);
  return response;
}

HttpResponse answer_login(const HttpRequest& request, const Visitor& visitor,
                          const HttpPages& pages) {
  const bool in = request.path() == kLoginPath;
  if (request.method == "POST")
    return in ? log_in(request, visitor, pages) : log_out(request, visitor, pages);
  if (request.method != "GET" || !in)
    return http_error(405, "use POST here", in ? "Allow: GET, POST\r\n" : "Allow: POST\r\n");
  if (const auto refused = refusal_of(request, visitor.is_tls, pages.access()))
    return refuse(*refused, pages);
  return login_state(entry_of(request, visitor, pages).person);
}

HttpResponse not_found(const HttpRequest& request) {
  return http_error(404, "there is no " + quoted(request.path()) +
                             " here; there are the console at /, /metrics, /healthz, /readyz, "
                             "/api/status and the other questions of the admin protocol, and a "
                             "WebSocket at /tims");
}

// All arguments of a query are texts; these are numbers in JSON.
constexpr std::array<std::string_view, 4> kNumbers{"limit", "since", "type", "wait_ms"};

std::optional<std::string> decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '+') {
      out += ' ';
    } else if (text[i] == '%') {
      const std::string_view digits = text.substr(i + 1, 2);
      const auto byte = base::parse_number<unsigned char>(digits, 16);
      if (!byte || digits.size() < 2) return std::nullopt;
      out += static_cast<char>(*byte);
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

json::value value_of(const std::string& key, const std::string& text) {
  const bool is_number = std::ranges::find(kNumbers, key) != kNumbers.end();
  // A text that is not a number is passed on; the answer explains the error.
  if (const auto number = base::parse_number<std::int64_t>(text); is_number && number)
    return *number;
  return json::string(base::valid_utf8(text));
}

bool is_port(std::string_view text) {
  return !text.empty() && text.size() <= 5 &&
         std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

// The host of "host", "host:port", "[::1]" and "[::1]:port", without brackets; empty for other
// texts.
std::string host_of(std::string_view text) {
  const bool bracketed = text.starts_with('[');
  const std::size_t end = bracketed ? text.find(']') : text.find(':');
  std::string_view host = text.substr(0, end);
  std::string_view rest = text.substr(std::min(end, text.size()));
  if (bracketed) {
    if (rest.empty()) return {};
    host.remove_prefix(1);
    rest.remove_prefix(1);
  }
  const bool well_formed = rest.empty() || (rest.front() == ':' && is_port(rest.substr(1)));
  if (!well_formed || (host.find(':') != std::string_view::npos) != bracketed) return {};
  return std::string(host);
}

bool is_numeric(const std::string& host) {
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  return ::inet_pton(AF_INET, host.c_str(), bytes.data()) == 1 ||
         ::inet_pton(AF_INET6, host.c_str(), bytes.data()) == 1;
}

}  // namespace

bool is_for_websocket(const HttpRequest& request) { return request.path() == kWebSocketPath; }

Entry entry_of(const HttpRequest& request, const Visitor& visitor, const HttpPages& pages) {
  if (must_use_tls(visitor, pages.access())) return {};
  if (!visitor.is_tls || !pages.access().login)
    return {.person = {.rights = rights_up_to(Right::kConfigure)}};
  const std::string_view bearer = bearer_of(request);
  const std::string_view session = bearer.empty() ? cookie_of(request) : bearer;
  const Person* person = pages.logins->use(pages.now(), session);
  return person == nullptr ? Entry{} : Entry{*person, std::string(session)};
}

std::optional<HttpResponse> websocket_refusal(const HttpRequest& request, const Visitor& visitor,
                                              const HttpPages& pages) {
  if (must_use_tls(visitor, pages.access())) return to_https(request, pages);
  if (request.method != "GET" || !request.wants_websocket)
    return http_error(426, "this is a WebSocket: one binary message is one TiMS message",
                      "Upgrade: websocket\r\nConnection: Upgrade\r\n");
  if (const auto refused = acting_refusal(request, visitor, pages)) return refuse(*refused, pages);
  if (!has(entry_of(request, visitor, pages).person.rights, Right::kLook)) return log_in_first();
  return std::nullopt;
}

HttpResponse answer_http(const HttpRequest& request, const Visitor& visitor,
                         const HttpPages& pages) {
  if (must_use_tls(visitor, pages.access())) return to_https(request, pages);
  const std::string_view path = request.path();
  if (path == kLoginPath || path == kLogoutPath) return answer_login(request, visitor, pages);
  const bool is_api = path.starts_with(kApiPath);
  const bool is_console = pages.console->has(path);
  if (!is_api && !is_console && path != "/metrics" && path != "/healthz" && path != "/readyz")
    return not_found(request);
  if (request.method != "GET" && request.method != "HEAD")
    return http_error(405, quoted(request.method) + ": this port is read-only: use GET",
                      "Allow: GET, HEAD\r\n");
  if (is_api) return answer_api(request, visitor, pages);
  if (is_console) return answer_console(request, pages);
  if (path == "/readyz") return answer_ready(pages);
  if (path == "/healthz") return {.body = "ok\n"};
  if (!has(entry_of(request, visitor, pages).person.rights, Right::kLook)) return log_in_first();
  return {.type = kMetricsType, .body = pages.metrics()};
}

std::optional<std::string> api_question(std::string_view ask, std::string_view query) {
  const auto verb = decoded(ask);
  if (!verb) return std::nullopt;
  json::object question;
  while (!query.empty()) {
    const std::size_t end = std::min(query.find('&'), query.size());
    const std::string_view pair = query.substr(0, end);
    query.remove_prefix(std::min(end + 1, query.size()));
    if (pair.empty()) continue;
    const std::size_t sign = std::min(pair.find('='), pair.size());
    const auto key = decoded(pair.substr(0, sign));
    const auto value = decoded(pair.substr(std::min(sign + 1, pair.size())));
    if (!key || !value) return std::nullopt;
    question[base::valid_utf8(*key)] = value_of(*key, *value);
  }
  question["ask"] = base::valid_utf8(*verb);
  return json::serialize(question);
}

std::optional<Refused> refusal_of(const HttpRequest& request, bool is_tls,
                                  const BrowserAccess& access) {
  if (auto refused = host_refusal(request, access)) return refused;
  // Browsers send Origin with every WebSocket, and Sec-Fetch-Site with every request to this
  // machine.
  if (has_field(request, "Origin")) {
    const std::string_view origin = only_field(request, "Origin");
    if (is_safe_origin(origin, is_tls, only_field(request, "Host"), access.origins))
      return std::nullopt;
    return Refused{HttpRefusal::kOrigin, refusal_text("origin", origin)};
  }
  const std::string_view site = only_field(request, "Sec-Fetch-Site");
  if (!has_field(request, "Sec-Fetch-Site") || site == "same-origin" || site == "none")
    return std::nullopt;
  return Refused{HttpRefusal::kCrossSite, refusal_text("Sec-Fetch-Site", site)};
}

bool is_safe_host(std::string_view host, std::span<const std::string> names) {
  const std::string name = host_of(host);
  if (name.empty()) return false;
  return equal_ignoring_case(name, "localhost") || is_numeric(name) ||
         std::ranges::any_of(
             names, [&](const std::string& safe) { return equal_ignoring_case(safe, name); });
}

bool is_safe_origin(std::string_view origin, bool is_tls, std::string_view host,
                    std::span<const std::string> origins) {
  const std::string_view scheme = is_tls ? "https://" : "http://";
  if (origin.starts_with(scheme)) {
    const std::string_view its_host = origin.substr(scheme.size());
    if (!host_of(its_host).empty() && equal_ignoring_case(its_host, host)) return true;
  }
  return std::ranges::any_of(
      origins, [&](const std::string& listed) { return equal_ignoring_case(listed, origin); });
}

}  // namespace tims::io

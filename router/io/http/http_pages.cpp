#include "router/io/http/http_pages.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "router/io/http/api_question.h"
#include "router/io/http/metrics_text.h"
#include "router/io/http/origin.h"

namespace tims::io {
namespace {

constexpr std::string_view kWebSocketPath = "/tims";
constexpr std::string_view kApiPath = "/api/";
constexpr std::string_view kJsonType = "application/json";

bool is_same_name(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return std::ranges::equal(a, b, {}, lower, lower);
}

// Empty when there is none, or more than one: then nobody knows which one counts.
std::string_view only_field(const HttpRequest& request, std::string_view name) {
  const auto has_name = [&](const auto& field) { return is_same_name(field.name, name); };
  if (std::ranges::count_if(request.fields, has_name) != 1) return {};
  return std::ranges::find_if(request.fields, has_name)->value;
}

bool has_field(const HttpRequest& request, std::string_view name) {
  return std::ranges::any_of(request.fields,
                             [&](const auto& field) { return is_same_name(field.name, name); });
}

// The asker's words, as much of them as is needed to recognise them.
std::string quoted(std::string_view text) { return fmt::format("\"{}\"", text.substr(0, 64)); }

std::optional<HttpResponse> host_refusal(const HttpRequest& request,
                                         std::span<const std::string> origins) {
  const std::string_view host = only_field(request, "Host");
  if (is_safe_host(host, origins)) return std::nullopt;
  return http_error(403, "host " + quoted(host) +
                             ": only a number such as 127.0.0.1, localhost and the names in "
                             "http.origins are taken here, since any web site can point a name of "
                             "its own at this machine");
}

HttpResponse answer_api(const HttpRequest& request, const HttpPages& pages) {
  if (auto refusal = host_refusal(request, pages.origins())) return *refusal;
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

HttpResponse not_found(const HttpRequest& request) {
  return http_error(404, "there is no " + quoted(request.path()) +
                             " here; there are /metrics, /healthz, /readyz, /api/status and the "
                             "other questions of the admin protocol, and a WebSocket at /tims");
}

}  // namespace

bool is_for_websocket(const HttpRequest& request) { return request.path() == kWebSocketPath; }

std::optional<HttpResponse> websocket_refusal(const HttpRequest& request,
                                              std::span<const std::string> origins) {
  if (request.method != "GET" || !request.wants_websocket)
    return http_error(426, "here is a WebSocket: one binary message is one TiMS message",
                      "Upgrade: websocket\r\nConnection: Upgrade\r\n");
  if (auto refusal = host_refusal(request, origins)) return refusal;
  // Browsers always say where a page comes from; other programs need not.
  const std::string_view origin = only_field(request, "Origin");
  if (!has_field(request, "Origin") || is_safe_origin(origin, only_field(request, "Host"), origins))
    return std::nullopt;
  return http_error(403, "origin " + quoted(origin) +
                             ": only pages that came from this port may open a WebSocket here, and "
                             "those listed in http.origins");
}

HttpResponse answer_http(const HttpRequest& request, const HttpPages& pages) {
  const std::string_view path = request.path();
  const bool is_api = path.starts_with(kApiPath);
  if (!is_api && path != "/metrics" && path != "/healthz" && path != "/readyz")
    return not_found(request);
  if (request.method != "GET" && request.method != "HEAD")
    return http_error(405, quoted(request.method) + ": this port is for reading, with GET",
                      "Allow: GET, HEAD\r\n");
  if (is_api) return answer_api(request, pages);
  if (path == "/metrics") return {.type = kMetricsType, .body = pages.metrics()};
  if (path == "/readyz") return answer_ready(pages);
  return {.body = "ok\n"};
}

}  // namespace tims::io

// What is to be had at this port, and what is answered to everything else. Pure.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "router/io/http/http_request.h"
#include "router/io/http/http_response.h"

namespace tims::io {

struct HttpPages {
  std::function<std::string()> metrics;
  // Why the router is not ready for clients; empty when it is.
  std::function<std::string()> not_ready;
  // The answer to a question of the admin protocol.
  std::function<std::string(const std::string& question)> ask;
  // Pages from elsewhere that are welcome: see origin.h.
  std::function<std::span<const std::string>()> origins;
};

// Whether the request is for the place where WebSockets begin.
bool is_for_websocket(const HttpRequest& request);
// Why a request for that place is refused; nothing when the WebSocket may begin.
std::optional<HttpResponse> websocket_refusal(const HttpRequest& request,
                                              std::span<const std::string> origins);

HttpResponse answer_http(const HttpRequest& request, const HttpPages& pages);

}  // namespace tims::io

// What is to be had at this port, who may have it, and what is answered to everything else. Pure.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "router/io/http/http_message.h"

namespace tims::io {

inline constexpr std::string_view kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

struct HttpPages {
  std::function<std::string()> metrics;
  // Why the router is not ready for clients; empty when it is.
  std::function<std::string()> not_ready;
  // The answer to a question of the admin protocol.
  std::function<std::string(const std::string& question)> ask;
  // Pages from elsewhere that are welcome: see is_safe_origin().
  std::function<std::span<const std::string>()> origins;
};

// Whether the request is for the place where WebSockets begin.
bool is_for_websocket(const HttpRequest& request);
// Why a request for that place is refused; nothing when the WebSocket may begin.
std::optional<HttpResponse> websocket_refusal(const HttpRequest& request,
                                              std::span<const std::string> origins);

HttpResponse answer_http(const HttpRequest& request, const HttpPages& pages);

// --- questions

// "/api/mailboxes?match=Ladar(*%2F*)&limit=10" as a question of the admin protocol (ADMIN.md):
// {"ask":"mailboxes","match":"Ladar(*/*)","limit":10}.
//
// `query` is what stands behind the question mark. Nothing when an escape in it is broken. Whether
// the question makes sense is the admin protocol's business.
std::optional<std::string> api_question(std::string_view ask, std::string_view query);

// --- who may talk to this port from a browser
//
// A page of any site can make a browser send requests
// here; what it cannot do is forge the Host and Origin fields. `origins`: http.origins, pages from
// elsewhere that are welcome ("http://robot7:3000").

// A Host field that is a number or "localhost", with or without a port, or that of one of
// `origins`. A site that points its own name at this machine (DNS rebinding) comes with that name.
bool is_safe_host(std::string_view host, std::span<const std::string> origins = {});

// An Origin field of a page that came from here, "http://" and what the Host field says, or from
// one of `origins`. Pages of other ports are strangers, on this machine too: any user may serve
// them. So is "null", which any site can be.
bool is_safe_origin(std::string_view origin, std::string_view host,
                    std::span<const std::string> origins = {});

}  // namespace tims::io

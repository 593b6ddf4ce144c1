#include "router/io/http/http_response.h"

#include <utility>

#include <fmt/format.h>

namespace tims::io {
namespace {

std::string_view phrase(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 400:
      return "Bad Request";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 408:
      return "Request Timeout";
    case 413:
      return "Content Too Large";
    case 426:
      return "Upgrade Required";
    case 431:
      return "Request Header Fields Too Large";
    case 503:
      return "Service Unavailable";
    case 505:
      return "HTTP Version Not Supported";
    default:
      return "Error";
  }
}

}  // namespace

HttpResponse http_error(int status, std::string text, std::string_view field) {
  return {.status = status, .body = std::move(text) + "\n", .field = field};
}

// nosniff: a text that quotes somebody's words must not be taken for a page.
std::string to_bytes(const HttpResponse& response, HttpFraming framing) {
  return fmt::format(
      "HTTP/1.1 {} {}\r\n"
      "Content-Type: {}\r\n"
      "Content-Length: {}\r\n"
      "Cache-Control: no-store\r\n"
      "X-Content-Type-Options: nosniff\r\n"
      "Connection: {}\r\n"
      "{}\r\n{}",
      response.status, phrase(response.status), response.type, response.body.size(),
      framing.keep_alive ? "keep-alive" : "close", response.field,
      framing.with_body ? std::string_view(response.body) : std::string_view());
}

}  // namespace tims::io

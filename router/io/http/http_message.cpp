#include "router/io/http/http_message.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <fmt/format.h>

namespace tims::io {
namespace {

namespace http = boost::beast::http;
using Parser = http::request_parser<http::string_body>;

std::string_view phrase(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 304:
      return "Not Modified";
    case 308:
      return "Permanent Redirect";
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
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

std::string text(boost::beast::string_view view) { return {view.data(), view.size()}; }

HttpRequest plain(const http::request<http::string_body>& message) {
  HttpRequest request{.method = text(message.method_string()),
                      .target = text(message.target()),
                      .version = static_cast<int>(message.version()),
                      .fields = {},
                      .body = message.body(),
                      .keep_alive = message.keep_alive(),
                      .wants_websocket = boost::beast::websocket::is_upgrade(message)};
  for (const auto& field : message)
    request.fields.push_back({text(field.name_string()), text(field.value())});
  return request;
}

HttpResponse refusal_for(boost::beast::error_code error) {
  if (error == http::error::header_limit)
    return http_error(431, "the head of a request has at most 8192 bytes here");
  if (error == http::error::body_limit)
    return http_error(413, "the body of a request has at most 4096 bytes here");
  if (error == http::error::bad_version) return http_error(505, "this is not HTTP/1.0 or HTTP/1.1");
  return http_error(400, "this is not an HTTP request: " + error.message());
}

}  // namespace

HttpResponse http_error(int status, std::string text, std::string_view field) {
  return {.status = status, .body = std::move(text) + "\n", .field = field};
}

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return std::ranges::equal(a, b, {}, lower, lower);
}

// nosniff: a text that quotes untrusted input must not be interpreted as a page.
std::string to_bytes(const HttpResponse& response, HttpFraming framing) {
  // 304 has no body, and its length would be that of the file.
  const std::string length =
      response.status == 304
          ? std::string()
          : fmt::format("Content-Length: {}\r\n", response.body.size() + response.stored.size());
  return fmt::format(
      "HTTP/1.1 {} {}\r\n"
      "Content-Type: {}\r\n"
      "{}"
      "Cache-Control: {}\r\n"
      "X-Content-Type-Options: nosniff\r\n"
      "Connection: {}\r\n"
      "{}{}\r\n{}",
      response.status, phrase(response.status), response.type, length, response.cache,
      framing.keep_alive ? "keep-alive" : "close", response.field, response.more_fields,
      framing.with_body ? std::string_view(response.body) : std::string_view());
}

struct HttpReader::Impl {
  Impl() { begin(); }

  void begin() {
    parser.emplace();
    parser->header_limit(kHttpHeadBytesMax);
    parser->body_limit(kHttpBodyBytesMax);
    head_size = 0;
  }
  void drop(std::size_t n) {
    std::copy(buffer.begin() + static_cast<std::ptrdiff_t>(n),
              buffer.begin() + static_cast<std::ptrdiff_t>(filled), buffer.begin());
    filled -= n;
  }
  Status refuse(boost::beast::error_code error) {
    refusal = refusal_for(error);
    return Status::kRefused;
  }

  std::optional<Parser> parser;
  std::array<char, kHttpHeadBytesMax> buffer;
  std::size_t filled = 0;
  std::size_t head_size = 0;
  HttpRequest request;
  std::optional<HttpResponse> refusal;
};

HttpReader::HttpReader() : impl_(std::make_unique<Impl>()) {}
HttpReader::~HttpReader() = default;

std::span<char> HttpReader::room() { return std::span(impl_->buffer).subspan(impl_->filled); }
void HttpReader::advance(std::size_t n) { impl_->filled += n; }

HttpReader::Status HttpReader::next() {
  Impl& in = *impl_;
  if (in.refusal) return Status::kRefused;
  while (in.filled > 0) {
    boost::beast::error_code error;
    const bool in_head = !in.parser->is_header_done();
    const std::size_t used =
        in.parser->put(boost::asio::buffer(in.buffer.data(), in.filled), error);
    in.drop(used);
    // The parser's own limit applies to each field separately.
    if (in_head) in.head_size += used;
    if (in.head_size > kHttpHeadBytesMax) return in.refuse(http::error::header_limit);
    if (in.parser->is_done()) {
      in.request = plain(in.parser->get());
      in.begin();
      return Status::kRequest;
    }
    if (error == http::error::need_more) {
      // The parser needs the whole head, or the whole line of a chunk, in one piece.
      if (in.filled == in.buffer.size()) return in.refuse(http::error::header_limit);
      if (used == 0) break;
      continue;
    }
    if (error) return in.refuse(error);
  }
  return Status::kNeedMore;
}

const HttpRequest& HttpReader::request() const { return impl_->request; }
const HttpResponse& HttpReader::refusal() const { return *impl_->refusal; }
std::size_t HttpReader::pending() const { return impl_->filled; }
bool HttpReader::is_inside() const { return impl_->filled > 0 || impl_->parser->got_some(); }

}  // namespace tims::io

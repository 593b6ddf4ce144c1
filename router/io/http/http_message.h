// HTTP messages: decodes requests from the bytes of a connection and encodes answers. Pure: the
// caller reads and writes the socket. The parser is Boost.Beast's, behind a plain interface,
// because including it costs 3 s of compile time per file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tims::io {

struct HttpRequest {
  struct Field {
    std::string name;  // as received: compare without regard to case
    std::string value;
  };

  std::string method{};  // "GET"
  std::string target{};  // "/api/status?x=1", not decoded
  int version = 11;      // 10 or 11
  std::vector<Field> fields{};
  std::string body{};
  bool keep_alive = true;        // the connection stays open for further requests
  bool wants_websocket = false;  // asks for an upgrade to a WebSocket

  [[nodiscard]] std::string_view path() const {
    return std::string_view(target).substr(0, target.find('?'));
  }
  // The part after the question mark.
  [[nodiscard]] std::string_view query() const {
    const std::size_t mark = target.find('?');
    return mark == std::string::npos ? std::string_view()
                                     : std::string_view(target).substr(mark + 1);
  }
};

// Names of fields, hosts and codings are the same in any case.
bool equal_ignoring_case(std::string_view a, std::string_view b);

inline constexpr std::string_view kTextType = "text/plain; charset=utf-8";

struct HttpResponse {
  int status = 200;
  std::string_view type = kTextType;
  std::string body;
  // Additional fields with their line ends, such as "Allow: GET\r\n".
  std::string_view field{};
  std::string more_fields{};            // likewise
  std::string_view cache = "no-store";  // Cache-Control
  // Sent in place of `body`, without a copy: it outlives the connection.
  std::string_view stored{};
};

// A refusal as text: what was refused, and what to do.
HttpResponse http_error(int status, std::string text, std::string_view field = {});

struct HttpFraming {
  bool with_body = true;  // false for HEAD
  bool keep_alive = true;
};
// Without the stored bytes.
std::string to_bytes(const HttpResponse& response, HttpFraming framing);

inline constexpr std::size_t kHttpHeadBytesMax = 8 << 10;
inline constexpr std::size_t kHttpBodyBytesMax = 4 << 10;  // longer ones are refused

// Decodes requests from the bytes of a connection, which may be split anywhere.
class HttpReader {
 public:
  HttpReader();
  ~HttpReader();
  HttpReader(const HttpReader&) = delete;
  HttpReader& operator=(const HttpReader&) = delete;

  enum class Status {
    kRequest,   // request() is set; call next() again
    kNeedMore,  // read into room()
    kRefused,   // refusal() is set; the beginning of the next request is unknown
  };

  // Buffer for the next bytes; not empty after kNeedMore. Afterwards call advance() and next().
  std::span<char> room();
  void advance(std::size_t n);

  Status next();
  [[nodiscard]] const HttpRequest& request() const;
  [[nodiscard]] const HttpResponse& refusal() const;

  // Number of bytes received after the last request.
  [[nodiscard]] std::size_t pending() const;
  // True when a request has begun and is not complete.
  [[nodiscard]] bool is_inside() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tims::io

// HTTP messages: requests out of the bytes of a connection, answers into bytes. Pure: the caller
// reads and writes the socket. The parser is Boost.Beast's, behind a plain interface; its include
// costs 3 s a file.
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
    std::string name;  // as it was sent: compare without regard to case
    std::string value;
  };

  std::string method{};  // "GET"
  std::string target{};  // "/api/status?x=1", nothing decoded
  int version = 11;      // 10 or 11
  std::vector<Field> fields{};
  bool keep_alive = true;        // the connection stays for further requests
  bool wants_websocket = false;  // it asks to go on as a WebSocket

  [[nodiscard]] std::string_view path() const {
    return std::string_view(target).substr(0, target.find('?'));
  }
  // What stands behind the question mark.
  [[nodiscard]] std::string_view query() const {
    const std::size_t mark = target.find('?');
    return mark == std::string::npos ? std::string_view()
                                     : std::string_view(target).substr(mark + 1);
  }
};

inline constexpr std::string_view kTextType = "text/plain; charset=utf-8";

struct HttpResponse {
  int status = 200;
  std::string_view type = kTextType;
  std::string body;
  // One more field with its line end, such as "Allow: GET\r\n".
  std::string_view field{};
};

// A refusal in words: what was refused, and what to do.
HttpResponse http_error(int status, std::string text, std::string_view field = {});

struct HttpFraming {
  bool with_body = true;  // not for HEAD
  bool keep_alive = true;
};
std::string to_bytes(const HttpResponse& response, HttpFraming framing);

inline constexpr std::size_t kHttpHeadBytesMax = 8 << 10;
inline constexpr std::size_t kHttpBodyBytesMax = 4 << 10;  // read and thrown away

// Bytes of a connection, split anywhere, into requests.
class HttpReader {
 public:
  HttpReader();
  ~HttpReader();
  HttpReader(const HttpReader&) = delete;
  HttpReader& operator=(const HttpReader&) = delete;

  enum class Status {
    kRequest,   // request() is set; call next() again
    kNeedMore,  // read into room()
    kRefused,   // refusal() is set; where the next request would begin is not known
  };

  // Where the next bytes may be read to; not empty after kNeedMore. Then advance() and next().
  std::span<char> room();
  void advance(std::size_t n);

  Status next();
  [[nodiscard]] const HttpRequest& request() const;
  [[nodiscard]] const HttpResponse& refusal() const;

  // Bytes that came behind the last request.
  [[nodiscard]] std::size_t pending() const;
  // Whether a request has begun and is not complete.
  [[nodiscard]] bool is_inside() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tims::io

// Bytes of a connection, split anywhere, into HTTP requests. Pure: the caller reads the socket.
//
// The parser is Boost.Beast's, behind a plain interface; its include costs 3 s a file.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "router/io/http/http_request.h"
#include "router/io/http/http_response.h"

namespace tims::io {

inline constexpr std::size_t kHttpHeadBytesMax = 8 << 10;
inline constexpr std::size_t kHttpBodyBytesMax = 4 << 10;  // read and thrown away

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

// An HTTP answer, and its bytes. Pure.
#pragma once

#include <string>
#include <string_view>

namespace tims::io {

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

}  // namespace tims::io

// An HTTP request, as plain values.
#pragma once

#include <cstdint>
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

}  // namespace tims::io

// An IP camera for tests: motion JPEG by HTTP (multipart/x-mixed-replace).
#pragma once

#include "tests/support/one_client_server.h"
#include "tims/time.h"

namespace tims::test {

enum class MjpegAnswer : std::uint8_t {
  kPictures,      // without end
  kSilence,       // accepts, and sends nothing
  kPage,          // an HTML page instead of pictures
  kNotFound,      // HTTP 404
  kUnauthorized,  // HTTP 401
};

struct MjpegServerOptions {
  std::string jpeg{};
  std::uint16_t port = 0;  // 0: any
  MjpegAnswer answer = MjpegAnswer::kPictures;
  Duration period = std::chrono::milliseconds(20);
  std::uint32_t pauses_after = 0;  // pictures; 0: it does not
};

class MjpegServer final : public OneClientServer {
 public:
  explicit MjpegServer(MjpegServerOptions options);
  ~MjpegServer() override;

  // user: "name:password@".
  [[nodiscard]] std::string url(const std::string& user = {}) const {
    return "http://" + user + "127.0.0.1:" + std::to_string(port()) + "/video.mjpg?channel=1";
  }
  // Sent until now, to all clients.
  [[nodiscard]] std::uint32_t pictures() const { return pictures_; }

 private:
  void serve(int client) override;

  MjpegServerOptions options_;
  std::atomic<std::uint32_t> pictures_{0};
};

}  // namespace tims::test

// An IP camera for tests: RTSP (RFC 2326) with JPEG in RTP (RFC 2435), both over one TCP
// connection, as most clients ask for it.
#pragma once

#include "tests/support/one_client_server.h"
#include "tims/time.h"

namespace tims::test {

struct RtspServerOptions {
  // Baseline, 4:2:0, with the standard Huffman tables, of less than 60 kB.
  std::string jpeg{};
  int width = 0;  // multiples of 8
  int height = 0;
  std::uint16_t port = 0;  // 0: any
  Duration period = std::chrono::milliseconds(40);
};

class RtspServer final : public OneClientServer {
 public:
  explicit RtspServer(RtspServerOptions options);
  ~RtspServer() override;

  [[nodiscard]] std::string url(const std::string& user = {}) const {
    return "rtsp://" + user + "127.0.0.1:" + std::to_string(port()) + "/stream1";
  }
  // Sessions that a client has ended by TEARDOWN.
  [[nodiscard]] std::uint32_t teardowns() const { return teardowns_; }

 private:
  void serve(int client) override;
  void answer(int client, const std::string& request);
  void send_picture(int client);

  RtspServerOptions options_;
  std::string payload_;  // of a packet, behind the header of RTP
  std::atomic<std::uint32_t> teardowns_{0};
  bool plays_ = false;
  std::uint16_t packets_ = 0;
};

}  // namespace tims::test

#include "tests/support/mjpeg_server.h"

#include <utility>

#include "os/clock.h"

namespace tims::test {
namespace {

std::string head_of(MjpegAnswer answer) {
  switch (answer) {
    case MjpegAnswer::kPictures:
      return "HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=part\r\n\r\n";
    case MjpegAnswer::kSilence:
      return {};
    case MjpegAnswer::kPage:
      return "HTTP/1.0 200 OK\r\nContent-Type: text/html\r\nContent-Length: "
             "13\r\n\r\n<html></html>";
    case MjpegAnswer::kNotFound:
      return "HTTP/1.0 404 Not Found\r\nContent-Length: 0\r\n\r\n";
    case MjpegAnswer::kUnauthorized:
      return "HTTP/1.0 401 Unauthorized\r\nWWW-Authenticate: Basic realm=\"camera\"\r\n"
             "Content-Length: 0\r\n\r\n";
  }
  return {};
}

}  // namespace

MjpegServer::MjpegServer(MjpegServerOptions options)
    : OneClientServer(options.port), options_(std::move(options)) {
  start();
}

MjpegServer::~MjpegServer() { stop(); }

void MjpegServer::serve(int client) {
  while (!ends() && receive(client).empty()) {
  }
  send(client, head_of(options_.answer));
  const bool stays =
      options_.answer == MjpegAnswer::kPictures || options_.answer == MjpegAnswer::kSilence;
  const std::string part = "--part\r\nContent-Type: image/jpeg\r\nContent-Length: " +
                           std::to_string(options_.jpeg.size()) + "\r\n\r\n" + options_.jpeg +
                           "\r\n";
  Time next = os::now();
  for (std::uint32_t sent = 0; stays && !ends();) {
    (void)receive(client);
    const bool pauses = options_.answer == MjpegAnswer::kSilence ||
                        (options_.pauses_after > 0 && sent >= options_.pauses_after);
    if (pauses || os::now() < next) continue;
    send(client, part);
    next += options_.period;
    ++sent;
    ++pictures_;
  }
}

}  // namespace tims::test

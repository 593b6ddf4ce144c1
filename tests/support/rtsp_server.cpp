#include "tests/support/rtsp_server.h"

#include <utility>

#include "os/clock.h"

namespace tims::test {
namespace {

constexpr std::uint32_t kClock = 90'000;  // of RTP's times, 1/s

char byte(std::size_t number) { return static_cast<char>(number & 0xFFU); }

std::string big_endian(std::size_t number, int bytes) {
  std::string text;
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) text += byte(number >> shift);
  return text;
}

struct Parts {
  std::string quantisation;  // both tables
  std::string scan;          // compressed pixels
};

// RFC 2435 sends these two; the rest follows from its header.
Parts parts_of(const std::string& jpeg) {
  Parts parts;
  for (std::size_t at = 2; at + 4 <= jpeg.size();) {
    const auto marker = static_cast<unsigned char>(jpeg[at + 1]);
    const std::size_t size =
        static_cast<unsigned char>(jpeg[at + 2]) * 256U + static_cast<unsigned char>(jpeg[at + 3]);
    const std::string segment = jpeg.substr(at + 4, size - 2);
    at += 2 + size;
    if (marker == 0xDB)  // each table of 64 bytes begins with its number
      for (std::size_t i = 0; i + 65 <= segment.size(); i += 65)
        parts.quantisation += segment.substr(i + 1, 64);
    if (marker == 0xDA) {
      parts.scan = jpeg.substr(at, jpeg.size() - 2 - at);
      break;
    }
  }
  return parts;
}

std::string value_of(const std::string& request, const std::string& name) {
  const std::size_t at = request.find(name + ": ");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + name.size() + 2;
  return request.substr(begin, request.find("\r\n", begin) - begin);
}

}  // namespace

RtspServer::RtspServer(RtspServerOptions options)
    : OneClientServer(options.port), options_(std::move(options)) {
  const Parts parts = parts_of(options_.jpeg);
  // Type-specific, offset of the fragment, type 4:2:0, tables follow, size.
  payload_ = big_endian(0, 4) + byte(1) + byte(255) +
             byte(static_cast<std::size_t>(options_.width) / 8) +
             byte(static_cast<std::size_t>(options_.height) / 8);
  payload_ += big_endian(0, 2) + big_endian(parts.quantisation.size(), 2) + parts.quantisation;
  payload_ += parts.scan;
  start();
}

RtspServer::~RtspServer() { stop(); }

void RtspServer::serve(int client) {
  plays_ = false;
  std::string received;
  for (Time next{}; !ends();) {
    received += receive(client);
    // Reports of the client about its reception.
    while (received.starts_with('$') && received.size() >= 4)
      received.erase(0, 4 + static_cast<unsigned char>(received[3]));
    const std::size_t end = received.find("\r\n\r\n");
    if (end != std::string::npos) {
      answer(client, received.substr(0, end + 2));
      received.erase(0, end + 4);
    }
    if (!plays_ || os::now() < next) continue;
    send_picture(client);
    next = os::now() + options_.period;
  }
}

void RtspServer::answer(int client, const std::string& request) {
  std::string text = "RTSP/1.0 200 OK\r\nCSeq: " + value_of(request, "CSeq") + "\r\n";
  std::string body;
  if (request.starts_with("OPTIONS")) text += "Public: DESCRIBE, SETUP, PLAY, TEARDOWN\r\n";
  if (request.starts_with("DESCRIBE")) {
    body =
        "v=0\r\no=- 0 0 IN IP4 127.0.0.1\r\ns=camera\r\nt=0 0\r\nm=video 0 RTP/AVP 26\r\n"
        "a=control:track1\r\n";
    text +=
        "Content-Type: application/sdp\r\nContent-Length: " + std::to_string(body.size()) + "\r\n";
  }
  if (request.starts_with("SETUP")) text += "Transport: RTP/AVP/TCP;unicast;interleaved=0-1\r\n";
  if (!request.starts_with("OPTIONS") && !request.starts_with("DESCRIBE")) text += "Session: 1\r\n";
  plays_ = plays_ || request.starts_with("PLAY");
  if (request.starts_with("TEARDOWN")) {
    ++teardowns_;
    plays_ = false;
  }
  send(client, text + "\r\n" + body);
}

void RtspServer::send_picture(int client) {
  const std::size_t time =
      packets_ *
      static_cast<std::size_t>(kClock * std::chrono::duration<double>(options_.period).count());
  // Version 2; the last packet of a picture, of JPEG; number, time and source.
  const std::string head = "\x80" + std::string(1, byte(0x80 | 26)) + big_endian(packets_++, 2) +
                           big_endian(time, 4) + big_endian(1, 4);
  const std::string packet = head + payload_;
  send(client, "$" + std::string(1, '\0') + big_endian(packet.size(), 2) + packet);
}

}  // namespace tims::test

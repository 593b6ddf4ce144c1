// Reads a page from a device by HTTP, for example the metadata of a scanner. Uses HTTP 1.0, so that
// the answer is not chunked and the device closes the connection after it.
#pragma once

#include <string>
#include <string_view>

#include "rack/devices/dialogue.h"

namespace rack::device {

class HttpGet final : public Dialogue {
 public:
  HttpGet(std::string host, std::string path) : host_(std::move(host)), path_(std::move(path)) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  // The connection was closed: this is the end of an answer without Content-Length.
  void on_closed();

  [[nodiscard]] bool is_done() const { return is_done_; }
  // The body of the complete answer.
  [[nodiscard]] const std::string& body() const { return body_; }

 private:
  void read(bool is_closed);
  void refuse(const std::string& why);

  std::string host_;
  std::string path_;
  std::string answer_;
  std::string body_;
  bool is_done_ = false;
};

}  // namespace rack::device

// Asks a device for a page of its own: how scanners in the network tell what they are. HTTP 1.0, so
// that the answer comes in one piece, and the connection is closed behind it.
#pragma once

#include <string>
#include <string_view>

#include "components/devices/core/dialogue.h"

namespace rack::device {

class HttpGet final : public Dialogue {
 public:
  HttpGet(std::string host, std::string path) : host_(std::move(host)), path_(std::move(path)) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return give_up_; }
  // The connection was closed: an answer that does not say how long it is ends with that.
  void on_closed();

  [[nodiscard]] bool is_done() const { return is_done_; }
  // Of an answer that is done.
  [[nodiscard]] const std::string& body() const { return body_; }

 private:
  void read(bool is_closed);
  void refuse(const std::string& why);

  std::string host_;
  std::string path_;
  std::string answer_;
  std::string body_;
  bool is_done_ = false;
  Time give_up_ = tims::kNever;
};

}  // namespace rack::device

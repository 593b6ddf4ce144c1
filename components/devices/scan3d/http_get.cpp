#include "components/devices/scan3d/http_get.h"

#include <algorithm>
#include <optional>

#include "base/text.h"

namespace rack::device {
namespace {

constexpr Duration kAnswerTime = std::chrono::seconds(2);
constexpr std::size_t kAnswerMax = 1 << 20;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// Reads Content-Length from the header lines.
std::optional<std::size_t> content_length(std::string_view head) {
  constexpr std::string_view kName = "content-length:";
  const auto found = std::ranges::search(head, kName, {}, lower);
  if (found.empty()) return std::nullopt;
  std::string_view text(found.end(), head.end());
  text = text.substr(0, text.find('\r'));
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  return tims::base::parse_number<std::size_t>(text);
}

}  // namespace

void HttpGet::start(Time now, Output& out) {
  clear_failure();
  answer_.clear();
  body_.clear();
  is_done_ = false;
  timer_.wait_until(now + kAnswerTime);
  const std::string question = "GET " + path_ + " HTTP/1.0\r\nHost: " + host_ + "\r\n\r\n";
  out.send(std::as_bytes(std::span(question)));
}

void HttpGet::on_timeout(Time now, Output&) {
  if (timer_.take_due(now)) refuse("does not answer");
}

void HttpGet::on_arrival(const Arrival& arrival, Output&) {
  if (is_done_ || failure()) return;
  answer_.append(reinterpret_cast<const char*>(arrival.bytes.data()), arrival.bytes.size());
  if (answer_.size() > kAnswerMax)
    refuse("sent an answer that is too long");
  else
    read(false);
}

void HttpGet::on_closed() {
  if (!is_done_ && !failure()) read(true);
}

void HttpGet::read(bool is_closed) {
  constexpr std::string_view kEndOfHead = "\r\n\r\n";
  const std::size_t head = answer_.find(kEndOfHead);
  if (head == std::string::npos) {
    if (is_closed) refuse("closed the connection without an answer");
    return;
  }
  // "HTTP/1.1 200 OK"
  const std::string_view first = std::string_view(answer_).substr(0, answer_.find('\r'));
  const std::size_t status = first.find(' ');
  if (!first.starts_with("HTTP/") || status == std::string_view::npos) {
    refuse("sent an answer that is not HTTP");
    return;
  }
  if (!first.substr(status + 1).starts_with("200")) {
    refuse("answered " + tims::base::in_quotes(first.substr(status + 1)));
    return;
  }
  const auto length = content_length(std::string_view(answer_).substr(0, head));
  const std::size_t there = answer_.size() - head - kEndOfHead.size();
  if (there < length.value_or(is_closed ? 0 : kAnswerMax)) {
    if (is_closed) refuse("closed the connection before the end of its answer");
    return;
  }
  body_ = answer_.substr(head + kEndOfHead.size(), length.value_or(there));
  is_done_ = true;
  timer_.stop();
}

void HttpGet::refuse(const std::string& why) {
  fail(tims::Errc::kAnsweredError, "http://" + host_ + path_ + ": the device " + why);
}

}  // namespace rack::device

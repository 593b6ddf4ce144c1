#include "components/devices/camera/ip_camera.h"

#include <algorithm>
#include <utility>

#include "components/devices/camera/test_pictures.h"

namespace rack::device::emulator {

namespace {

constexpr Duration kLookAgain = std::chrono::milliseconds(3);  // for a picture that is being made
constexpr std::string_view kBoundary = "rack-picture";

class TestPictures final : public PictureSource {
 public:
  [[nodiscard]] Duration period() const override { return std::chrono::milliseconds(100); }
  void order(Time) override { is_ordered_ = true; }
  bool take(std::vector<std::byte>& jpeg) override {
    if (!std::exchange(is_ordered_, false)) return false;
    is_bright_ = !is_bright_;
    const auto assign = [&](const auto& bytes) {
      const auto all = std::as_bytes(std::span(bytes));
      jpeg.assign(all.begin(), all.end());
    };
    is_bright_ ? assign(kBrightBar) : assign(kDarkBar);
    return true;
  }

 private:
  bool is_ordered_ = false;
  bool is_bright_ = false;
};

// The first word of the text, and removes it with the space behind it.
std::string_view take_word(std::string_view& text) {
  const std::size_t end = std::min(text.find(' '), text.size());
  const std::string_view word = text.substr(0, end);
  text.remove_prefix(std::min(text.size(), end + 1));
  return word;
}

}  // namespace

IpCamera::IpCamera(IpCameraSettings settings) : pictures_(std::move(settings.pictures)) {
  if (!pictures_) pictures_ = std::make_shared<TestPictures>();
}

void IpCamera::start(Time, Output&) {
  request_.clear();
  task_ = Task::kNone;
  timer_.stop();
}

void IpCamera::on_arrival(const Arrival& arrival, Output& out) {
  constexpr std::string_view kEnd = "\r\n\r\n";
  request_.append(reinterpret_cast<const char*>(arrival.bytes.data()), arrival.bytes.size());
  // Several requests are answered one after the other; what they do not end is kept.
  std::size_t begin = 0;
  for (std::size_t end = 0; (end = request_.find(kEnd, begin)) != std::string::npos;) {
    answer(std::string_view(request_).substr(begin, end - begin), arrival.last, out);
    begin = end + kEnd.size();
  }
  request_.erase(0, begin);
  if (request_.size() <= kRequestBytesMax) return;
  request_.clear();
  refuse("431 Request Header Fields Too Large", "", out);
}

void IpCamera::answer(std::string_view request, Time now, Output& out) {
  std::string_view line = request.substr(0, request.find("\r\n"));
  const std::string_view method = take_word(line);
  std::string_view path = take_word(line);
  if (!line.starts_with("HTTP/1.") || !path.starts_with('/'))
    return refuse("400 Bad Request", "", out);
  if (method != "GET") return refuse("405 Method Not Allowed", "Allow: GET\r\n", out);
  path = path.substr(0, path.find('?'));
  if (path == "/picture.jpg") return begin(Task::kPicture, now);
  if (path != "/") return refuse("404 Not Found", "", out);
  send_text(
      "HTTP/1.1 200 OK\r\nConnection: close\r\nCache-Control: no-store\r\n"
      "Content-Type: multipart/x-mixed-replace; boundary=" +
          std::string(kBoundary) + "\r\n\r\n",
      out);
  begin(Task::kStream, now);
}

void IpCamera::begin(Task task, Time now) {
  // A picture that is ready now was ordered for a previous client, or long ago.
  (void)pictures_->take(jpeg_);
  task_ = task;
  is_ordered_ = false;
  due_ = now;
  timer_.wait_until(now);
}

void IpCamera::refuse(std::string_view status, std::string_view more, Output& out) {
  task_ = Task::kNone;
  timer_.stop();
  send_text(
      "HTTP/1.1 " + std::string(status) + "\r\n" + std::string(more) + "Content-Length: 0\r\n\r\n",
      out);
}

void IpCamera::send_text(std::string_view text, Output& out) {
  out.send(std::as_bytes(std::span(text)));
}

void IpCamera::send_picture(Output& out) {
  if (jpeg_.size() > kPictureBytesMax) return;
  const bool is_part = task_ == Task::kStream;
  const std::string head =
      (is_part ? "--" + std::string(kBoundary) + "\r\n" : std::string("HTTP/1.1 200 OK\r\n")) +
      "Content-Type: image/jpeg\r\nContent-Length: " + std::to_string(jpeg_.size()) + "\r\n\r\n";
  const std::string_view tail = is_part ? "\r\n" : "";
  piece_.clear();
  for (const auto& part : {std::as_bytes(std::span(std::string_view(head))),
                           std::span<const std::byte>(jpeg_), std::as_bytes(std::span(tail))})
    piece_.insert(piece_.end(), part.begin(), part.end());
  out.send(piece_);
}

// A picture that is late is not made up for: the next ones keep their times.
void IpCamera::on_timeout(Time now, Output& out) {
  if (!timer_.take_due(now) || task_ == Task::kNone) return;
  if (is_ordered_ && pictures_->take(jpeg_)) {
    is_ordered_ = false;
    send_picture(out);
    if (task_ == Task::kPicture) {
      task_ = Task::kNone;
      return;
    }
  }
  const Duration period = std::max(pictures_->period(), kLookAgain);
  if (now >= due_) {
    pictures_->order(due_ + period <= now ? now : due_);
    is_ordered_ = true;
    const auto passed = (now - due_) / period + 1;
    due_ += passed * period;
  }
  timer_.wait_until(is_ordered_ ? std::min(due_, now + kLookAgain) : due_);
}

}  // namespace rack::device::emulator

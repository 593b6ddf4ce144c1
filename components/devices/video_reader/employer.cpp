#include "components/devices/video_reader/employer.h"

#include <array>
#include <cerrno>
#include <thread>

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "os/clock.h"

namespace rack::device {
namespace {

// For a library to say good-bye to a camera, so that this does not keep a session for a client that
// is gone.
constexpr auto kGoodbye = std::chrono::milliseconds(200);

// A library may block for any time, so that another thread must end it.
void end_when_gone(int socket) {
  pollfd wait{.fd = socket, .events = POLLRDHUP, .revents = 0};
  while (::poll(&wait, 1, -1) < 0 && errno == EINTR) {
  }
  std::this_thread::sleep_for(kGoodbye);
  ::_exit(0);
}

}  // namespace

Employer::Employer(int socket) : socket_(socket) { std::thread(end_when_gone, socket).detach(); }

tims::Result<std::string> Employer::receive_address() const {
  std::string text(kVideoNoteBytesMax, '\0');
  ssize_t size = 0;
  do {
    size = ::recv(socket_, text.data(), text.size(), 0);
  } while (size < 0 && errno == EINTR);
  if (size <= 0) return tims::os::system_error("address of the device");
  text.resize(static_cast<std::size_t>(size));
  return text;
}

void Employer::send(VideoNote note, std::string_view text) {
  std::string message(1, static_cast<char>(note));
  message += text.substr(0, kVideoNoteBytesMax - 1);
  // If the queue is full, the driver has enough notes to read that wake it.
  const int flags = note == VideoNote::kFrame ? MSG_NOSIGNAL | MSG_DONTWAIT : MSG_NOSIGNAL;
  if (::send(socket_, message.data(), message.size(), flags) < 0 && errno == EPIPE) is_gone_ = true;
  if (note == VideoNote::kFrame) ++not_taken_;
}

void Employer::wait_until_taken() {
  while (not_taken_ > 0 && !is_gone_) take_notes(true);
}

void Employer::wait_until(tims::Time due) {
  for (;;) {
    take_notes(false);
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(due - tims::os::now());
    if (is_gone_ || left.count() <= 0) return;
    pollfd wait{.fd = socket_, .events = POLLIN, .revents = 0};
    constexpr std::int64_t kLongestMs = 60'000;
    ::poll(&wait, 1, static_cast<int>(std::min(left.count(), kLongestMs)));
  }
}

bool Employer::is_gone() {
  take_notes(false);
  return is_gone_;
}

void Employer::take_notes(bool waits) {
  std::array<char, 16> note{};
  while (!is_gone_) {
    const ssize_t size = ::recv(socket_, note.data(), note.size(), waits ? 0 : MSG_DONTWAIT);
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return;
    if (size <= 0) is_gone_ = true;
    if (size > 0 && not_taken_ > 0) --not_taken_;
    if (waits) return;
  }
}

}  // namespace rack::device

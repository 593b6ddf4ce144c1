#include "client/router_link.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/socket.h"
#include "os/wakeup.h"

namespace tims::client {

namespace {

using namespace std::chrono_literals;
// Request number of a record that was not requested.
constexpr std::uint32_t kUnasked = 0;
constexpr Duration kRetryFirst = 10ms;
constexpr Duration kRetryLast = 500ms;

Result<void> send_packet(int socket, std::uint32_t request, const wire::Record& record,
                         std::span<const int> files, bool wait) {
  std::vector<std::byte> bytes;
  wire::encode({request, record}, bytes);
  return os::send_record(socket, bytes, files, wait);
}

// Timeout of send calls.
void set_timeout(int socket, Duration timeout) {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(timeout).count();
  const timeval value{.tv_sec = static_cast<std::time_t>(us / 1'000'000),
                      .tv_usec = static_cast<suseconds_t>(us % 1'000'000)};
  ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &value, sizeof value);
}

bool readable_before_stop(int socket, int stop) {
  std::array<pollfd, 2> waits{{{socket, POLLIN, 0}, {stop, POLLIN, 0}}};
  return os::poll_until(waits, os::deadline_after(RouterLink::kAnswerTimeout)) &&
         waits[1].revents == 0;
}

}  // namespace

Result<void> Greeting::send(const wire::Record& record, std::span<const int> files) const {
  return send_packet(socket_, 0, record, files, true);
}

Result<Answer> Greeting::ask(const wire::Record& record, std::span<const int> files) const {
  if (auto sent = send(record, files); !sent) return sent.error();
  std::vector<std::byte> buffer(wire::kRecordBytesMax);
  if (!readable_before_stop(socket_, stop_))
    return Error(Errc::kNoRouter, "the router did not answer");
  auto received = os::receive_record(socket_, buffer, false);
  if (!received) return Error(Errc::kNoRouter, "the router did not answer");
  if (received->size == 0) return Error(Errc::kNoRouter, "the router closed the connection");
  auto decoded = wire::decode(std::span(buffer).first(received->size));
  if (!decoded.packet) return Error(Errc::kVersion, std::string(decoded.problem));
  return Answer{std::move(decoded.packet->record), std::move(received->files)};
}

RouterLink::RouterLink(Settings settings, Listener& listener)
    : settings_(std::move(settings)),
      where_(wire::to_string(settings_.router)),
      listener_(listener),
      buffer_(wire::kRecordBytesMax) {}

RouterLink::~RouterLink() {
  if (!thread_.joinable()) return;
  os::signal_event_fd(stop_.get());
  thread_.join();
}

void RouterLink::start() {
  if (auto stop = os::make_event_fd()) stop_ = std::move(*stop);
  thread_ = std::thread([this] { run(); });
}

Result<void> RouterLink::wait_connected(Time deadline) {
  std::unique_lock lock(mutex_);
  const Duration patience = deadline == kNever ? kForever : deadline - os::now();
  if (!wait(lock, patience, [this] { return connected_ || refused_; }))
    return Error(Errc::kTimeout, "no router at " + where_);
  if (refused_) return *refused_;
  return {};
}

Result<void> RouterLink::wait_connected(const GoOn& go_on) {
  for (;;) {
    auto ready = wait_connected(os::now() + kSlice);
    if (ready || !(ready.error() == Errc::kTimeout)) return ready;
    if (!go_on()) return ended_early();
  }
}

Result<std::vector<Answer>> RouterLink::exchange(const wire::Record& record,
                                                 std::span<const int> files, std::size_t answers,
                                                 Duration patience) {
  return exchange_with(record, files, answers, [&](auto& lock, const auto& settled) {
    return wait(lock, patience, settled);
  });
}

Result<std::vector<Answer>> RouterLink::exchange(const wire::Record& record,
                                                 std::span<const int> files, std::size_t answers,
                                                 const GoOn& go_on) {
  bool is_ended = false;
  auto result = exchange_with(record, files, answers, [&](auto& lock, const auto& settled) {
    while (!wait(lock, kSlice, settled)) {
      lock.unlock();  // it may wait, for Python's interpreter for example
      is_ended = !go_on();
      lock.lock();
      if (is_ended) return settled();
    }
    return true;
  });
  if (!result && is_ended) return ended_early();
  return result;
}

template <typename Wait>
Result<std::vector<Answer>> RouterLink::exchange_with(const wire::Record& record,
                                                      std::span<const int> files,
                                                      std::size_t answers, Wait wait_for_answers) {
  Pending pending{.expected = answers, .answers = {}, .failed = false};
  std::unique_lock lock(mutex_);
  if (!connected_) return Error(Errc::kNoRouter, "no router at " + where_);
  const std::uint32_t request = ++last_request_;
  // Sent under the lock: the socket cannot be replaced during the call.
  if (auto sent = send_packet(socket_.get(), request, record, files, true); !sent)
    return Error(Errc::kNoRouter, sent.error().message());
  pending_[request] = &pending;
  const auto settled = [&] { return pending.failed || pending.answers.size() >= pending.expected; };
  const bool done = wait_for_answers(lock, settled);
  pending_.erase(request);
  if (!done || pending.failed)
    return Error(Errc::kNoRouter, "the router at " + where_ + " did not answer");
  return std::move(pending.answers);
}

bool RouterLink::ask_later(Address address) {
  const std::unique_lock lock(mutex_, std::try_to_lock);
  return lock.owns_lock() && connected_ &&
         send_packet(socket_.get(), kUnasked, wire::Lookup{{address}}, {}, false).ok();
}

Time RouterLink::connected_at() const {
  const std::lock_guard lock(mutex_);
  return connected_at_;
}

wire::Welcome RouterLink::welcome() const {
  const std::lock_guard lock(mutex_);
  return welcome_;
}

void RouterLink::run() {
  Duration wait = kRetryFirst;
  std::uint64_t former = 0;
  bool is_reported = false;
  for (;;) {
    if (const auto connected = connect()) {
      serve();
      disconnect();
      if (stopping_within({})) return;
      listener_.lost();
      listener_.event(SessionEvent::Kind::kLost, "lost the router at " + where_ + ", trying again");
      // If a router closes every connection immediately, wait longer before each reconnect; not
      // if it was restarted: the next one waits for its programs, but not for long.
      const bool is_another = std::exchange(former, welcome().epoch) != welcome().epoch;
      if (is_another || os::now() - connected_at() > kRetryLast) wait = kRetryFirst;
      is_reported = true;  // the event kLost replaces the message
    } else if (!is_reported) {
      const bool silent =
          connected.error() == Errc::kNoRouter || connected.error() == Errc::kSystem;
      const std::string why = silent ? "" : ": " + connected.error().message();
      listener_.event(SessionEvent::Kind::kWaiting, "waiting for a router at " + where_ + why);
      is_reported = true;
    }
    if (stopping_within(wait)) return;
    wait = std::min(2 * wait, kRetryLast);
  }
}

Result<void> RouterLink::connect() {
  auto socket = dial();
  if (!socket) return socket.error();
  set_timeout(socket->get(), kAnswerTimeout);
  if (auto greeted = hello(socket->get()); !greeted) {
    if (greeted.error() == Errc::kNoRouter) return greeted.error();
    const std::lock_guard lock(mutex_);
    refused_ = greeted.error();
    changed_.notify_all();
    return greeted;
  }
  Greeting greeting(socket->get(), stop_.get());
  if (auto registered = listener_.greet(greeting); !registered) return registered.error();
  {
    const std::lock_guard lock(mutex_);
    socket_ = std::move(*socket);
    connected_at_ = os::now();
    refused_.reset();
    connection_.fetch_add(1, std::memory_order_release);
    connected_ = true;
    changed_.notify_all();
  }
  listener_.event(SessionEvent::Kind::kConnected, "connected to the router at " + where_);
  return {};
}

Result<os::File> RouterLink::dial() {
  if (const auto* tcp = std::get_if<wire::TcpEndpoint>(&settings_.router)) return dial(*tcp);
  auto socket = os::connect_unix(std::get<wire::UnixEndpoint>(settings_.router).path);
  if (!socket && errno == EACCES)
    return Error(Errc::kRefused, "permission denied, is this user in the group of the socket?");
  return socket;
}

// The session talks to a bridge with the same protocol as to a local router.
Result<os::File> RouterLink::dial(const wire::TcpEndpoint& router) {
  bridge_.reset();  // its connection has ended
  // A mailbox counts the messages that are too large for it; only a message that no router sends
  // ends the connection.
  const std::uint32_t received_max = std::max(settings_.tcp_message_max, TcpClient::kReceivedMax);
  auto client =
      TcpClient::connect(router, os::deadline_after(kAnswerTimeout), received_max, stop_.get());
  if (!client) return client.error();
  auto ends = os::make_record_pair();
  if (!ends) return ends.error();
  bridge_ =
      std::make_unique<TcpBridge>(std::move(*client), std::move(ends->other),
                                  TcpBridge::Settings{.where = where_,
                                                      .message_max = settings_.tcp_message_max,
                                                      .priority = settings_.tcp_priority});
  return std::move(ends->one);
}

Result<void> RouterLink::hello(int socket) {
  Greeting greeting(socket, stop_.get());
  auto answer = greeting.ask(wire::Hello{.writer = welcome().writer, .name = settings_.name});
  if (!answer) return answer.error();
  if (const auto* no = std::get_if<wire::Refused>(&answer->record))
    return Error(Errc::kRefused, no->text);
  const auto* yes = std::get_if<wire::Welcome>(&answer->record);
  if (yes == nullptr || yes->version != wire::kLocalVersion)
    return Error(Errc::kVersion, "the router at " + where_ + " speaks another protocol");
  const std::lock_guard lock(mutex_);
  welcome_ = *yes;
  return {};
}

void RouterLink::serve() {
  std::array<pollfd, 2> waits{{{socket_.get(), POLLIN, 0}, {stop_.get(), POLLIN, 0}}};
  for (;;) {
    (void)os::poll_until(waits, kNever);
    if (waits[1].revents != 0) return;
    if (waits[0].revents != 0 && !receive()) return;
  }
}

bool RouterLink::receive() {
  auto received = os::receive_record(socket_.get(), buffer_, false);
  if (!received) return received.error() == Errc::kEmpty;
  if (received->size == 0) return false;
  auto decoded = wire::decode(std::span(buffer_).first(received->size));
  if (!decoded.packet) return false;
  dispatch(std::move(*decoded.packet), std::move(received->files));
  return true;
}

void RouterLink::dispatch(wire::Packet packet, std::vector<os::File> files) {
  if (const auto* moved = std::get_if<wire::Moved>(&packet.record)) {
    listener_.moved(moved->address);
    return;
  }
  if (const auto* found = std::get_if<wire::Found>(&packet.record);
      found != nullptr && packet.request == kUnasked) {
    const wire::Found copy = *found;
    Answer answer{std::move(packet.record), std::move(files)};
    listener_.found(copy, answer);
    return;
  }
  const std::lock_guard lock(mutex_);
  const auto pending = pending_.find(packet.request);
  if (pending == pending_.end()) return;  // the requesting thread has given up
  pending->second->answers.push_back({std::move(packet.record), std::move(files)});
  changed_.notify_all();
}

void RouterLink::disconnect() {
  const std::lock_guard lock(mutex_);
  connected_ = false;
  socket_.reset();
  for (auto& [request, pending] : pending_) pending->failed = true;
  changed_.notify_all();
}

bool RouterLink::stopping_within(Duration wait) { return os::is_readable(stop_.get(), wait); }

}  // namespace tims::client

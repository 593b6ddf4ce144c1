#include "router/io/dds/dds_process.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <system_error>
#include <utility>

#include <fmt/core.h>
#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"

namespace tims::io {
namespace {

constexpr int kAnswerMs = 10'000;
constexpr int kRoomMs = 1'000;
constexpr int kSocketBytes = 1 << 20;

std::string system_text() { return std::generic_category().message(errno); }

// Its socket is closed, so it has ended, or is about to.
os::ExitStatus end_of(const os::Process& process) {
  constexpr Duration kEndsWithin = std::chrono::milliseconds(100);
  if (!process.has_ended(kEndsWithin)) process.signal(SIGKILL);
  (void)process.has_ended(std::chrono::seconds(10));
  return process.reap();
}

}  // namespace

DdsProcess::DdsProcess(Loop& loop, Log& log, DdsSettings settings, Listener& listener)
    : loop_(loop),
      log_(log),
      settings_(std::move(settings)),
      listener_(listener),
      retry_(loop, [this] { try_again(); }),
      in_(std::make_unique<std::array<std::byte, helper::kRecordMax>>()),
      out_(std::make_unique<std::array<std::byte, helper::kRecordMax>>()) {}

DdsProcess::~DdsProcess() { stop(); }

Result<void> DdsProcess::start(const link::Announcement& self) {
  self_ = self;
  if (!launch_or_retry()) {
    listener_.on_state();
    return {};
  }
  if (auto done = wait_for_answer(); !done) {
    end_process();
    return done;
  }
  return {};
}

Result<void> DdsProcess::launch() {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0)
    return Error(Errc::kSystem, "socketpair: " + system_text());
  socket_ = os::File(ends[0]);
  const os::File theirs(ends[1]);
  for (const int end : ends)
    (void)::setsockopt(end, SOL_SOCKET, SO_SNDBUF, &kSocketBytes, sizeof(kSocketBytes));
  auto started = os::Process::start({.command = {kProgram, std::to_string(theirs.get())},
                                     .inherited = theirs.get(),
                                     .own_group = true});
  if (!started) {
    const std::string why = errno == ENOENT ? "it is not installed (apt install tims-router-dds); "
                                              "links use their other paths"
                                            : system_text();
    socket_.reset();
    return Error(Errc::kSystem, fmt::format("cannot start {}, which runs DDS: {}", kProgram, why));
  }
  process_.emplace(std::move(*started));
  launched_ = os::now();
  report_ = {.state = State::kStarting};
  refused_ = 0;
  watch_.emplace(loop_, socket_.get(), [this](Ready) { on_ready(); });
  tell(helper::Start{settings_, self_});
  return {};
}

// Settings that cannot work end the start of the router.
Result<void> DdsProcess::wait_for_answer() {
  pollfd answer{socket_.get(), POLLIN, 0};
  if (::poll(&answer, 1, kAnswerMs) != 1)
    return Error(Errc::kSystem, fmt::format("{} does not answer", kProgram));
  const ssize_t size = ::recv(socket_.get(), in_->data(), in_->size(), MSG_DONTWAIT);
  const auto record = size > 0
                          ? helper::decode(std::span(*in_).first(static_cast<std::size_t>(size)))
                          : std::nullopt;
  const auto* started = record ? std::get_if<helper::Started>(&*record) : nullptr;
  if (started == nullptr) return Error(Errc::kSystem, fmt::format("{} has ended", kProgram));
  if (!started->error.empty()) return Error(Errc::kInvalidArgument, started->error);
  return {};
}

void DdsProcess::restart(const link::Announcement& self) {
  self_ = self;
  tell(helper::Restart{self});
}

void DdsProcess::stop() {
  retry_.cancel();
  if (!process_) return;
  // It sends what waits and says goodbye to the others; then its end of the socket closes.
  watch_.reset();
  if (put(helper::Stop{})) {
    pollfd end{socket_.get(), POLLIN, 0};
    const Time limit = os::now() + std::chrono::seconds(4);
    for (ssize_t size = 1; size > 0 && os::now() < limit;) {
      if (::poll(&end, 1, kRoomMs) != 1) continue;
      size = ::recv(socket_.get(), in_->data(), in_->size(), MSG_DONTWAIT);
    }
  }
  end_process();
  report_ = {};
}

void DdsProcess::end_process() {
  watch_.reset();
  socket_.reset();
  if (!process_) return;
  (void)end_of(*process_);
  process_.reset();
}

// --- records

bool DdsProcess::put(const helper::Record& record) {
  if (!socket_) return false;
  const std::size_t size = helper::encode(record, *out_);
  return size > 0 && ::send(socket_.get(), out_->data(), size, MSG_DONTWAIT | MSG_NOSIGNAL) > 0;
}

void DdsProcess::tell(const helper::Record& record) {
  if (!socket_ || put(record)) return;
  pollfd room{socket_.get(), POLLOUT, 0};
  if (::poll(&room, 1, kRoomMs) == 1 && put(record)) return;
  // It hangs. Its end is noticed by the loop.
  process_->signal(SIGKILL);
}

bool DdsProcess::send(const link::Burst& burst) {
  if (put(burst)) return true;
  refused_ += burst.count();
  return false;
}

DdsProcess::Counters DdsProcess::counters() const {
  Counters all = report_.counters;
  all.refused += refused_;
  return all;
}

void DdsProcess::on_ready() {
  const ssize_t size = ::recv(socket_.get(), in_->data(), in_->size(), MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (size <= 0) return on_end("");
  auto record = helper::decode(std::span(*in_).first(static_cast<std::size_t>(size)));
  if (!record) return on_end("it sends what it should not");
  take(std::move(*record));
  listener_.on_turn_end();
}

void DdsProcess::take(helper::Record&& record) {
  if (auto* arrived = std::get_if<helper::Arrived>(&record)) {
    link::Batch(arrived->batch).for_each([&](std::span<std::byte> datagram) {
      listener_.on_datagram(arrived->from, datagram);
    });
  } else if (auto* announced = std::get_if<helper::Announced>(&record)) {
    if (known_.add(announced->announcement.dds)) listener_.on_announced(announced->announcement);
  } else if (auto* gone = std::get_if<helper::Gone>(&record)) {
    known_.remove(gone->dds);
    listener_.on_gone(gone->dds);
  } else if (auto* report = std::get_if<helper::Report>(&record)) {
    const bool changed = report->state != report_.state || report->address != report_.address ||
                         report->last_error != report_.last_error;
    report_ = std::move(*report);
    if (report_.state == State::kUp && os::now() > launched_ + kPauseMax) pause_ = kPause;
    if (changed) listener_.on_state();
  } else if (const auto* started = std::get_if<helper::Started>(&record)) {
    if (!started->error.empty()) log_.warning("dds: " + started->error);
  } else {
    on_end("it sends what only a router sends");
  }
}

void DdsProcess::on_end(const std::string& why) {
  watch_.reset();
  socket_.reset();
  if (!why.empty()) process_->signal(SIGKILL);
  const std::string how = end_of(*process_).to_string();
  process_.reset();
  report_ = {.state = State::kStarting,
             .last_error = fmt::format("its helper process has ended ({}) and is started again",
                                       why.empty() ? how : why)};
  for (const link::NetAddress& dds : known_.take()) listener_.on_gone(dds);
  listener_.on_state();
  retry_.set(os::now() + pause_);
  pause_ = std::min(2 * pause_, kPauseMax);
  listener_.on_turn_end();
}

bool DdsProcess::launch_or_retry() {
  const auto done = launch();
  if (!done) {
    report_ = {.state = State::kStarting, .last_error = done.error().detail()};
    retry_.set(os::now() + kPauseMax);
  }
  return done.ok();
}

void DdsProcess::try_again() {
  launch_or_retry();
  listener_.on_state();
}

}  // namespace tims::io

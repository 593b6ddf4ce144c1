// tims-router-dds: DDS for a router that has started it (dds_process.h). Without rights: it can
// open no files but libraries, start no programs, and has the router's socket and those of IP.
#include <algorithm>
#include <array>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <sys/socket.h>
#include <unistd.h>

#include "os/clock.h"
#include "router/io/dds/confinement.h"
#include "router/io/dds/dds_process.h"

namespace {

using namespace tims;
using namespace tims::io;

constexpr Duration kReportEvery = std::chrono::seconds(1);
constexpr std::size_t kBatchMax = 60'000;

class Helper final : private DdsEngine::Listener {
 public:
  Helper(Loop& loop, Log& log, int socket, helper::Start start)
      : loop_(loop),
        socket_(socket),
        self_(std::move(start.self)),
        engine_(loop, log, std::move(start.settings), *this),
        watch_(loop, socket, [this](Ready) { on_ready(); }),
        reports_(loop, [this] { report(); }) {
    batch_.reserve(kBatchMax + link::kBatchedMax);
    const auto done = engine_.start(self_);
    tell(helper::Started{done ? "" : done.error().detail()});
    started_ = true;
    report();
  }
  // Before the engine's threads are ended: nothing is said any more.
  void stop() { engine_.stop(); }

 private:
  void on_ready() {
    const ssize_t size = ::recv(socket_, in_.data(), in_.size(), MSG_DONTWAIT);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
    auto record = size > 0 ? helper::decode(std::span(in_).first(static_cast<std::size_t>(size)))
                           : std::nullopt;
    if (!record || std::holds_alternative<helper::Stop>(*record)) return loop_.stop();
    if (const auto* burst = std::get_if<link::Burst>(&*record)) {
      (void)engine_.send(*burst);
    } else if (const auto* to = std::get_if<helper::Connect>(&*record)) {
      engine_.connect(to->to);
    } else if (auto* again = std::get_if<helper::Restart>(&*record)) {
      engine_.restart(self_ = std::move(again->self));
    }
    loop_.end_turn(os::now());
  }

  // DdsEngine::Listener
  void on_datagram(const link::NetAddress& from, std::span<std::byte> datagram) override {
    if (from != from_ || batch_.size() + datagram.size() + link::kBatchSizeBytes > kBatchMax)
      hand_on();
    from_ = from;
    batch_.push_back(static_cast<std::byte>(datagram.size() & 0xFF));
    batch_.push_back(static_cast<std::byte>(datagram.size() >> 8));
    batch_.insert(batch_.end(), datagram.begin(), datagram.end());
  }
  void on_announced(const link::Announcement& announcement) override {
    tell(helper::Announced{announcement});
  }
  void on_gone(const link::NetAddress& dds) override { tell(helper::Gone{dds}); }
  void on_state() override { report(); }
  void on_turn_end() override {
    hand_on();
    loop_.end_turn(os::now());
  }

  // Datagrams without room are lost, as they could be on the network.
  void hand_on() {
    if (batch_.empty()) return;
    (void)put(helper::Arrived{from_, batch_}, MSG_DONTWAIT);
    batch_.clear();
  }
  void report() {
    if (!started_) return;  // the answer to Start comes first
    reports_.set(os::now() + kReportEvery);
    tell(helper::Report{.state = engine_.state(),
                        .address = engine_.address(),
                        .host = engine_.host(),
                        .last_error = engine_.last_error(),
                        .counters = engine_.counters()});
  }
  void tell(const helper::Record& record) { (void)put(record, 0); }
  bool put(const helper::Record& record, int how) {
    const std::size_t size = helper::encode(record, out_);
    return size > 0 && ::send(socket_, out_.data(), size, how | MSG_NOSIGNAL) > 0;
  }

  Loop& loop_;
  const int socket_;
  link::Announcement self_;
  std::array<std::byte, helper::kRecordMax> in_{};
  std::array<std::byte, helper::kRecordMax> out_{};
  link::NetAddress from_{};
  std::vector<std::byte> batch_;
  bool started_ = false;
  DdsEngine engine_;
  Watch watch_;
  Timer reports_;
};

// The first record.
std::optional<helper::Start> wait_for_start(int socket) {
  std::vector<std::byte> bytes(helper::kRecordMax);
  const ssize_t size = ::recv(socket, bytes.data(), bytes.size(), 0);
  if (size <= 0) return std::nullopt;
  auto record = helper::decode(std::span(bytes).first(static_cast<std::size_t>(size)));
  auto* start = record ? std::get_if<helper::Start>(&*record) : nullptr;
  return start == nullptr ? std::nullopt : std::optional(std::move(*start));
}

}  // namespace

int main(int argc, char** argv) {
  // Signals for all processes of a unit are the router's affair: it ends this one.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::signal(signal, SIG_IGN);
  int socket = -1;
  const std::string_view number = argc == 2 ? argv[1] : "";
  (void)std::from_chars(number.data(), number.data() + number.size(), socket);
  auto start = wait_for_start(socket);
  if (!start) {
    std::fputs("tims-router-dds is only started by tims-router, for links over DDS\n", stderr);
    return 2;
  }
  std::vector<std::string> readable;
  Log log(config::LogLevel::kInfo);
  if (!start->settings.profiles.empty()) readable.push_back(start->settings.profiles);
  if (const auto done = confine(readable); !done)
    log.warning("dds: its process keeps rights that it does not need: " + done.error().detail());
  Loop loop;
  const auto helper = std::make_unique<Helper>(loop, log, socket, std::move(*start));
  loop.run();
  helper->stop();
  return 0;
}

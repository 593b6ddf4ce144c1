#include "tests/chaos/client.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "os/clock.h"
#include "router/core/random.h"
#include "router/core/types.h"
#include "tests/support/patience.h"
#include "tims/session.h"

namespace tims::chaos {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kBodyMax = 64U << 10;
constexpr std::uint32_t kSlots = 512;
constexpr Duration kPause = test::kSlowdown * 10ms;  // between two messages
// If the machine does not schedule a client for so long, links may time out as well.
constexpr Duration kStandstill = test::kSlowdown * 250ms;
constexpr std::int8_t kCommand = 21;

// The head of every body.
struct Stamp {
  std::uint32_t from;
  std::uint32_t to;
  std::uint32_t flow;
  std::uint32_t number;
};

void print_line(const std::string& text) {
  std::puts(text.c_str());
  std::fflush(stdout);
}

// A different pattern for every message.
void fill(const Stamp& stamp, std::span<std::byte> rest) {
  std::uint64_t state = std::uint64_t{stamp.from} << 40 ^ std::uint64_t{stamp.flow} << 32 ^
                        std::uint64_t{stamp.to} << 48 ^ stamp.number;
  for (std::byte& b : rest) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    b = static_cast<std::byte>(state >> 56);
  }
}

class Client {
 public:
  Client(Board& board, std::size_t own, Mailbox mailbox)
      : board_(board),
        own_(own),
        mailbox_(std::move(mailbox)),
        random_(core::spread(static_cast<std::uint64_t>(::getpid()))) {}

  [[noreturn]] void run() {
    for (Time next = os::now();;) {
      if (const auto message = mailbox_.peek_for(next - os::now())) {
        take(message->header(), message->body());
        continue;
      }
      const Time now = os::now();
      if (now > next + kStandstill) ++board_.standstills;
      next = std::max(next + kPause, now - 10 * kPause);
      const Phase phase = board_.phase;
      if (phase == Phase::kTraffic) send_something();
      if (phase == Phase::kTour) send((own_ + 1 + tour_++ % others()) % board_.clients, 7, 16);
    }
  }

 private:
  [[nodiscard]] std::size_t others() const { return board_.clients - 1; }
  std::size_t below(std::size_t limit) { return core::next_random(random_) % limit; }

  void send_something() {
    const std::size_t kind = below(100);
    const std::size_t size = kind < 60 ? below(64) : kind < 95 ? below(1400) : below(20'000);
    send((own_ + 1 + below(others())) % board_.clients, below(kFlows),
         kind == 99 ? below(kBodyMax - sizeof(Stamp)) : size);
  }

  void send(std::size_t to, std::size_t flow, std::size_t size) {
    Cell& cell = board_.cells[own_][to][flow];
    const Stamp stamp{static_cast<std::uint32_t>(own_), static_cast<std::uint32_t>(to),
                      static_cast<std::uint32_t>(flow), ++cell.sent};
    std::vector<std::byte> body(sizeof stamp + size);
    std::memcpy(body.data(), &stamp, sizeof stamp);
    fill(stamp, std::span(body).subspan(sizeof stamp));
    const bool command = stamp.number % 2 == 0 && flow != kSamples;
    const auto sent = mailbox_.send({.dest = board_.address(to),
                                     .type = command ? kCommand : type::kData,
                                     .priority = kPriorities.at(flow),
                                     .stream = flow == kSamples},
                                    body);
    if (!sent) ++cell.refused;
  }

  void take(const Header& header, std::span<const std::byte> body) {
    if (header.dest != mailbox_.address())
      return wrong(fmt::format("got a message for {}", header.dest.to_string()));
    if (header.type == type::kNotAvailable) return take_answer(header);
    Stamp stamp{};
    if (body.size() < sizeof stamp)
      return wrong(fmt::format("{} bytes of type {} from {}: never sent", body.size(), header.type,
                               header.src.to_string()));
    std::memcpy(&stamp, body.data(), sizeof stamp);
    const std::string what = fmt::format(
        "message {} of flow {} from client {} to client {} ({} bytes, source {})", stamp.number,
        stamp.flow, stamp.from, stamp.to, body.size(), header.src.to_string());
    if (stamp.from >= board_.clients || stamp.flow >= kFlows) return wrong(what + " is altered");
    if (stamp.to != own_ || board_.address(stamp.from) != header.src ||
        header.priority != kPriorities.at(stamp.flow))
      wrong(what + " is altered, or in the wrong mailbox");
    std::vector<std::byte> rest(body.size() - sizeof stamp);
    fill(stamp, rest);
    if (!std::ranges::equal(rest, body.subspan(sizeof stamp))) wrong(what + " has another body");
    check_order(stamp, what);
  }

  void take_answer(const Header& header) {
    const auto priority = std::ranges::find(kPriorities, header.priority);
    if (priority == kPriorities.end()) return wrong("an answer with a priority that no flow has");
    const auto flow = static_cast<std::size_t>(priority - kPriorities.begin());
    for (std::size_t to = 0; to < board_.clients; ++to)
      if (board_.address(to) == header.src) ++board_.cells[own_][to][flow].answered;
  }

  void check_order(const Stamp& stamp, const std::string& what) {
    Cell& cell = board_.cells[stamp.from][own_][stamp.flow];
    const std::uint32_t newest = cell.newest;
    if (stamp.number > cell.sent) wrong(what + ": its sender has not sent that many");
    if (stamp.number > newest) {
      const std::uint32_t ahead = stamp.number - newest;
      cell.seen = (ahead < 64 ? cell.seen << ahead : 0) | 1;
      cell.newest = stamp.number;
      ++cell.received;
      return;
    }
    const std::uint32_t behind = newest - stamp.number;
    const bool twice = behind < 64 && (cell.seen >> behind & 1) != 0;
    wrong(fmt::format("{} came after {}: {}", what, newest,
                      twice ? "twice" : "out of order (or a late duplicate)"));
  }

  void wrong(const std::string& what) {
    ++board_.wrong;
    print_line(fmt::format("WRONG: {:.3f} client {}: {}",
                           std::chrono::duration<double>(os::now().time_since_epoch()).count(),
                           own_, what));
  }

  Board& board_;
  const std::size_t own_;
  Mailbox mailbox_;
  std::uint64_t random_;
  std::size_t tour_ = 0;
};

// Retries, because the router may not have noticed yet that the previous owner has been killed.
Result<Mailbox> open(Session& session, const MailboxOptions& options) {
  for (const Time deadline = os::now() + test::kPatience;;) {
    auto mailbox = session.open(options);
    if (mailbox || !(mailbox.error() == Errc::kAddressInUse) || os::now() > deadline)
      return mailbox;
  }
}

}  // namespace

int run_client(const SharedBoard& board, std::size_t number) {
  const auto on_event = [&](const SessionEvent& event) {
    print_line(event.text);
    if (event.kind != SessionEvent::Kind::kMailboxLost) return;
    ++board->wrong;
    print_line("WRONG: another client has the address of this one");
  };
  auto session = Session::connect({.name = fmt::format("chaos{}", number), .on_event = on_event});
  if (!session) return print_line(session.error().message()), 1;
  auto mailbox = open(*session, {.address = board->address(number),
                                 .slots = kSlots,
                                 .body_max = kBodyMax,
                                 .priority = kPriorities.at(0)});
  if (!mailbox) return print_line(mailbox.error().message()), 1;
  Client(*board, number, std::move(*mailbox)).run();
}

}  // namespace tims::chaos

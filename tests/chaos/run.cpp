#include "tests/chaos/run.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>

#include <fmt/format.h>
#include <unistd.h>

#include "os/clock.h"
#include "router/core/types.h"
#include "tests/support/patience.h"
#include "tools/cli/failure.h"

namespace tims::chaos {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr Duration kLookEvery = test::kSlowdown * 1s;
constexpr Duration kLookAgain = 20ms;
constexpr Duration kSpanMax = 15s;
constexpr Duration kCalm = 2s;
constexpr int kCalmTries = 10;
constexpr Duration kStill = 500ms;

double seconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }

std::string own_program() { return fs::read_symlink("/proc/self/exe"); }

std::string new_folder() {
  std::string path = fs::temp_directory_path() / fmt::format("tims-chaos.{}", ::getpid());
  fs::create_directories(path);
  return path;
}

}  // namespace

Run::Run(const Settings& settings, const timsctl::Signals& signals)
    : settings_(settings),
      signals_(signals),
      began_(os::now()),
      shape_(make_shape(settings.robots)),
      folder_(new_folder()),
      board_(timsctl::value_or_fail(SharedBoard::at(folder_ + "/board"), folder_)) {
  board_->clients = static_cast<std::uint32_t>(shape_.clients());
  for (std::size_t i = 0; i < shape_.clients(); ++i)
    board_->addresses[i] = shape_.client_address(i).raw();
}

bool Run::go() {
  report(fmt::format("seed {}, {} hosts, {} clients", settings_.seed, shape_.hosts.size(),
                     shape_.clients()));
  const std::string file = folder_ + "/fleet.toml";
  std::ofstream(file) << fleet_file(shape_,
                                    fmt::format("{} client {{}} {}/board", own_program(), folder_));
  fleet_.emplace(timsctl::sim::RunningFleet::Options{.name = fmt::format("chaos{}", ::getpid()),
                                                     .file = file,
                                                     .log = folder_ + "/fleet.log",
                                                     .timsctl = TIMSCTL_PROGRAM,
                                                     .patience = test::kPatience});
  judge_.emplace(shape_, *fleet_, signals_, [this](const std::string& text) { wrong(text); });
  settle();
  for (std::size_t number = 1; wrongs_ == 0; ++number) {
    if (number > 2 && os::now() - began_ > settings_.length) break;
    round(number);
  }
  if (wrongs_ > 0) keep();
  const std::size_t memory = judge_->memory_max();
  judge_.reset();
  for (const std::string& what : fleet_->take_down()) wrong("not removed: " + what);
  fleet_.reset();
  if (wrongs_ == 0) fs::remove_all(folder_);
  report(fmt::format(
      "{} messages, {} steps; settled within {:.1f} s at most; largest router {:.1f} MiB; {} "
      "violations (seed {})",
      received(), steps_, seconds(slowest_), static_cast<double>(memory) / (1 << 20), wrongs_,
      settings_.seed));
  return wrongs_ == 0;
}

// --- a round

void Run::round(std::size_t number) {
  const Duration span = std::clamp<Duration>(settings_.length / 6, 1s, kSpanMax);
  const Round plan = plan_round(settings_.seed, number, shape_, span);
  report(fmt::format("round {}: {:.1f} s of faults{}", number, seconds(plan.span),
                     plan.kills ? ", with kills" : ""));
  const Losses missing_before = missing_by_class();
  const Losses counted_before = judge_->counted_losses();
  trouble(plan);
  heal();
  settle();
  tour();
  if (!plan.kills) judge_losses(missing_before, counted_before);
  calm();
  finish_round();
}

void Run::trouble(const Round& round) {
  board_->phase = Phase::kTraffic;
  const Time began = os::now();
  Time next_look = began + kLookEvery;
  for (const Step& step : round.steps) {
    for (; next_look < began + step.at; next_look = os::now() + kLookEvery) {
      pause_until(next_look);
      judge_->look();
    }
    pause_until(began + step.at);
    act(step);
  }
  pause_until(began + round.span);
}

void Run::heal() {
  for (const Step& step : healing(shape_)) fleet_->sim(step.arguments);
  board_->phase = Phase::kQuiet;
}

// Waits until every link is up and every router knows exactly the mailboxes it must know.
void Run::settle() {
  const Duration took = await("settled", [&] { return judge_->not_settled(); });
  slowest_ = std::max(slowest_, took);
  report(fmt::format("settled after {:.2f} s", seconds(took)));
}

// Every client sends to every other.
void Run::tour() {
  constexpr std::size_t kFlow = 7;
  const std::size_t clients = shape_.clients();
  std::vector<std::uint32_t> marks;
  for (std::size_t from = 0; from < clients; ++from)
    for (std::size_t to = 0; to < clients; ++to)
      marks.push_back(board_->cells[from][to][kFlow].sent);
  board_->phase = Phase::kTour;
  await("a message from every client to every other", [&]() -> std::string {
    for (std::size_t from = 0; from < clients; ++from)
      for (std::size_t to = 0; to < clients; ++to)
        if (from != to && board_->cells[from][to][kFlow].newest <= marks[from * clients + to])
          return fmt::format("nothing arrives from client {} at client {}", from, to);
    return {};
  });
  await_quiet();
}

// Without faults nothing may be lost, unless the machine stalls: then the check is repeated.
void Run::calm() {
  for (int i = 0; i < kCalmTries; ++i) {
    if (is_calm()) return;
    report("the machine stalled: repeating the check without faults");
    settle();
    await_quiet();
  }
}

// False: the machine stalled, so the check is not valid.
bool Run::is_calm() {
  const std::vector<std::uint32_t> before = missing();
  const std::uint32_t standstills = board_->standstills;
  board_->phase = Phase::kTraffic;
  pause_until(os::now() + kCalm);
  board_->phase = Phase::kQuiet;
  await("everything sent without faults has arrived", [&]() -> std::string {
    if (board_->standstills != standstills) return {};
    const std::vector<std::uint32_t> now = missing();
    const auto [a, b] = std::ranges::mismatch(now, before);
    if (a == now.end()) return {};
    const auto cell = static_cast<std::size_t>(a - now.begin());
    const std::size_t pair = cell / kSamples;
    return fmt::format("client {} to client {}, flow {}: {} lost before, {} now",
                       pair / shape_.clients(), pair % shape_.clients(), cell % kSamples, *b, *a);
  });
  return board_->standstills == standstills;
}

// For rounds without kills: every missing message must be counted by a router or a mailbox.
void Run::judge_losses(const Losses& missing_before, const Losses& counted_before) {
  const Losses missing_now = missing_by_class();
  const Losses counted_now = judge_->counted_losses();
  std::uint64_t all = 0;
  for (std::size_t c = 0; c < core::kClasses; ++c) {
    const std::uint64_t lost = missing_now[c] - missing_before[c];
    const std::uint64_t counted = counted_now[c] - counted_before[c];
    all += lost;
    if (lost > counted)
      wrong(fmt::format("{} messages of class {} are lost, but only {} were counted", lost, c,
                        counted));
  }
  report(fmt::format("{} messages lost, all of them counted", all));
}

void Run::finish_round() {
  judge_->look();
  for (const std::string& what : fleet_->ended()) wrong("exited by itself: " + what);
  if (board_->wrong > 0)
    wrong(fmt::format("clients reported {} violations: WRONG in component*.log",
                      board_->wrong.load()));
}

// --- the board

std::uint64_t Run::received() const {
  std::uint64_t sum = 0;
  for (const auto& from : board_->cells)
    for (const auto& to : from)
      for (const Cell& cell : to) sum += cell.received;
  return sum;
}

std::vector<std::uint32_t> Run::missing() const {
  std::vector<std::uint32_t> all;
  for (std::size_t from = 0; from < shape_.clients(); ++from)
    for (std::size_t to = 0; to < shape_.clients(); ++to)
      for (std::size_t flow = 0; flow < kSamples; ++flow)
        all.push_back(board_->cells[from][to][flow].missing());
  return all;
}

Losses Run::missing_by_class() const {
  Losses sums{};
  const std::vector<std::uint32_t> all = missing();
  for (std::size_t i = 0; i < all.size(); ++i)
    sums[core::kConventionalClasses.of(kPriorities.at(i % kSamples))] += all[i];
  return sums;
}

// Waits until no client sends, no message is queued, and none arrives.
void Run::await_quiet() {
  board_->phase = Phase::kQuiet;
  std::uint64_t before = received();
  Time since = os::now();
  await("quiet", [&]() -> std::string {
    const std::uint64_t now = received();
    if (now != std::exchange(before, now) || !judge_->nothing_waits()) since = os::now();
    return os::now() - since > kStill ? "" : "messages still arrive";
  });
}

// --- the rest

template <typename Missing>
Duration Run::await(const char* what, Missing missing) {
  const Time began = os::now();
  Duration patience = 2 * test::kPatience;  // counts only while this process is scheduled
  for (Time last = began;;) {
    const Time now = os::now();
    patience -= std::min(now - std::exchange(last, now), 1s + kLookAgain);
    const bool last_try = patience < Duration{};
    const std::string text = missing();
    if (text.empty()) return os::now() - began;
    if (last_try) {
      wrong(fmt::format("timeout after {:.0f} s: {}: {}", seconds(os::now() - began), what, text));
      return os::now() - began;
    }
    pause_until(os::now() + kLookAgain);
  }
}

void Run::act(const Step& step) {
  report(fmt::format("{}", fmt::join(step.arguments, " ")));
  fleet_->sim(step.arguments);
  ++steps_;
}

void Run::report(const std::string& text) const {
  std::printf("%8.2f  %s\n", seconds(os::now() - began_), text.c_str());
  std::fflush(stdout);
}

void Run::wrong(const std::string& text) {
  ++wrongs_;
  report("WRONG: " + text);
}

void Run::keep() {
  judge_->save(folder_);
  fleet_->save(folder_);
  report("logs and router tables: " + folder_);
}

}  // namespace tims::chaos

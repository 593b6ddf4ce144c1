// timsctl top: who sends and receives how much, live.
#include <array>
#include <map>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <termios.h>
#include <unistd.h>

#include "base/measure.h"
#include "base/text.h"
#include "base/wall_time.h"
#include "os/clock.h"
#include "tools/cli/context.h"
#include "tools/cli/failure.h"
#include "tools/timsctl/rates.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

namespace {

using namespace std::chrono_literals;

constexpr Column kColumns[] = {
    {"CLIENT", "id", As::kCount},
    {"NAME", "name"},
    {"PORT", "port"},
    {"PID", "pid", As::kText},
    {"MAILBOXES", "mailboxes", As::kCount},
    {"TAKEN/S", "taken_per_s", As::kRate},
    {"IN/S", "in_per_s", As::kRate},
    {"OUT/S", "out_per_s", As::kRate},
    {"IN_BYTES/S", "in_bytes_per_s", As::kBytes},
    {"OUT_BYTES/S", "out_bytes_per_s", As::kBytes},
    {"DROPS", "drops", As::kCount, false, true},
    {"QUEUE", "queue_bytes", As::kBytes},
};
// Single keys from a terminal, without Enter and without echo, until this goes.
enum class Key { kNone, kQuit, kLeft, kRight };

class Keys {
 public:
  Keys();  // does nothing when stdin is no terminal
  ~Keys();
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  // To wait on; -1 when there are no keys.
  [[nodiscard]] int descriptor() const;
  Key read() const;

 private:
  std::optional<termios> before_;
};

Keys::Keys() {
  termios now{};
  if (::isatty(STDIN_FILENO) == 0 || ::tcgetattr(STDIN_FILENO, &now) != 0) return;
  before_ = now;
  now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  now.c_cc[VMIN] = 0;
  now.c_cc[VTIME] = 0;
  ::tcsetattr(STDIN_FILENO, TCSANOW, &now);
}

Keys::~Keys() {
  if (before_) ::tcsetattr(STDIN_FILENO, TCSANOW, &*before_);
}

int Keys::descriptor() const { return before_ ? STDIN_FILENO : -1; }

Key Keys::read() const {
  std::array<char, 16> buffer{};
  const ssize_t size = ::read(STDIN_FILENO, buffer.data(), buffer.size());
  if (size == 0) return Key::kQuit;  // the terminal has gone
  const std::string_view text(buffer.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  if (text == "q" || text == "Q") return Key::kQuit;
  if (text == "\033[D" || text == "<") return Key::kLeft;
  if (text == "\033[C" || text == ">") return Key::kRight;
  return Key::kNone;
}

constexpr std::size_t kFirstSortable = 4;

// Asking for each of very many mailboxes every second would be a load of its own.
constexpr double kMailboxesMax = 5000;

class Top {
 public:
  explicit Top(Context& context) : context_(context), sort_(context.options.sort) {
    if (sort_.empty()) sort_ = kColumns[column_].title;
    for (std::size_t i = 0; i < std::size(kColumns); ++i)
      if (kColumns[i].title == sort_) column_ = i;
  }

  Exit run();

 private:
  void sample();
  void draw();
  void wait_until(tims::Time deadline);
  [[nodiscard]] std::string heading() const;

  Context& context_;
  std::string sort_;
  std::size_t column_ = 5;
  bool quit_ = false;
  std::unique_ptr<Connection> connection_;
  TopRates rates_;
  json::object status_;
  json::array items_;
  std::optional<Keys> keys_;
};

Exit Top::run() {
  const Options& options = context_.options;
  const bool live = context_.out.terminal() && !context_.out.json() && options.count != 1;
  if (live) {
    keys_.emplace();
    context_.out.write("\033[2J");
  }
  const tims::Duration interval = options.interval.value_or(1s);
  const std::uint64_t count = options.count.value_or(UINT64_MAX);
  const tims::Time end = context_.run_end();
  sample();
  tims::Time next = tims::os::now();
  for (std::uint64_t i = 0; i < count && !quit_ && next < end; ++i) {
    next = std::min(next + interval, end);
    wait_until(next);
    if (quit_) break;
    try {
      sample();
      draw();
    } catch (const Failure& failure) {
      if (!live || (failure.exit != Exit::kNoRouter && failure.exit != Exit::kTimeout)) throw;
      connection_.reset();
      context_.out.redraw(failure.message + ", trying again\n");
    }
  }
  return Exit::kDone;
}

void Top::sample() {
  if (!connection_) connection_ = context_.connect();
  AdminClient admin = context_.admin(*connection_);
  status_ = admin.ask({{"ask", "status"}});
  const json::object clients = admin.ask({{"ask", "clients"}});
  json::object mailboxes;
  if (number_or_zero(status_, "mailboxes") <= kMailboxesMax)
    mailboxes = admin.ask({{"ask", "mailboxes"}});
  items_ = rates_.update(tims::os::now(), items_of(clients), items_of(std::as_const(mailboxes)));
}

void Top::draw() {
  if (context_.out.json())
    return context_.out.write(json::object{{"schema", "tims/top/1"},
                                           {"router", text_at(status_, "router")},
                                           {"time", base::rfc3339(tims::os::wall_now())},
                                           {"items", items_}});
  sort_items(items_, kColumns, sort_);
  const std::string table =
      render_items({items_.data(), items_.size()}, kColumns, context_.out.look());
  keys_ ? context_.out.redraw(heading() + table) : context_.out.write(table);
}

std::string Top::heading() const {
  return fmt::format(
      "{} up {}, {} clients, {} mailboxes, {} dropped in the last minute   by {}; q quits, left "
      "and "
      "right choose\n\n",
      base::printable(text_at(status_, "name")),
      base::human_duration(number_or_zero(status_, "uptime_s")), number_or_zero(status_, "clients"),
      number_or_zero(status_, "mailboxes"), number_or_zero(status_, "drops_last_minute"), sort_);
}

void Top::wait_until(tims::Time deadline) {
  const int fd = keys_ ? keys_->descriptor() : -1;
  while (context_.signals.wait(fd, deadline) == Signals::Woken::kReadable) {
    const Key key = keys_->read();
    if (key == Key::kQuit) quit_ = true;
    if (quit_) return;
    if (key == Key::kLeft && column_ > kFirstSortable) --column_;
    if (key == Key::kRight && column_ + 1 < std::size(kColumns)) ++column_;
    if (key == Key::kNone) continue;
    sort_ = kColumns[column_].title;
    draw();
  }
}

}  // namespace

Exit top(Context& context) { return Top(context).run(); }

}  // namespace timsctl

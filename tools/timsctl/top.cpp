// timsctl top: who sends and receives how much, live.
#include <map>

#include <fmt/format.h>

#include "os/clock.h"
#include "tools/timsctl/commands.h"
#include "tools/timsctl/context.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/humanize.h"
#include "tools/timsctl/keys.h"
#include "tools/timsctl/top_rates.h"

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
                                           {"time", rfc3339(wall_now())},
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
      printable(text_at(status_, "name")), human_duration(number_or_zero(status_, "uptime_s")),
      number_or_zero(status_, "clients"), number_or_zero(status_, "mailboxes"),
      number_or_zero(status_, "drops_last_minute"), sort_);
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

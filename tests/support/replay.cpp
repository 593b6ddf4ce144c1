#include "tests/support/replay.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "os/clock.h"
#include "tests/support/origins.h"
#include "tests/support/replay_network.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace {

namespace router_command = wire::router_command;
using Line = recorded::Line;

// A message with an invalid length must be refused as soon as its header has arrived, long before
// the watchdog would close the connection.
constexpr Duration kRefusalLimit = std::chrono::seconds(3);

bool is_restart(const recorded::Mark& mark) { return mark.text.starts_with("K1"); }

bool is_lifesign_answer(const Header& h) { return is_router_message(h) && h.type == type::kOk; }

// The line after which a connection stops answering lifesigns: the last one, for connections that
// the router closes because they do not answer.
std::set<int> last_lines_of_silent_clients(const Recording& recording) {
  std::set<int> lines;
  std::map<int, int> last_line;
  std::set<int> broken;  // connections whose close has another reason
  bool restarted = false;
  for (const Line& line : recording.lines) {
    if (const auto* mark = std::get_if<recorded::Mark>(&line.event)) {
      restarted = restarted || is_restart(*mark);
    } else if (const auto* message = std::get_if<recorded::Message>(&line.event)) {
      const Header header = message->view().header;
      if (!is_lifesign(header) && !is_lifesign_answer(header)) last_line[line.conn] = line.number;
    } else if (std::holds_alternative<recorded::Partial>(line.event)) {
      broken.insert(line.conn);
    } else if (const auto* close = std::get_if<recorded::Close>(&line.event)) {
      const bool is_silent = close->by_router && !broken.contains(line.conn) && !restarted;
      if (is_silent) lines.insert(last_line[line.conn]);
    }
  }
  return lines;
}

// Executes the lines of a recording in order.
class Walk {
 public:
  Walk(const Recording& recording, const ReplayOptions& options)
      : recording_(recording),
        options_(options),
        network_(options),
        last_lines_of_silent_(last_lines_of_silent_clients(recording)) {}

  ReplayResult run();

 private:
  void on(const recorded::Message& message);
  void on(const recorded::Connect& connect);
  void on(const recorded::Partial& partial);
  void on(const recorded::Close& close);
  void on(const recorded::Mark& mark);

  void wait_for_moment(const Line& line);
  void settle();
  void become_sender(int conn);
  void fence_sender();
  void close_as_client(ReplayConnection& c, bool reset);
  void wait_for_close_by_router(ReplayConnection& c, Duration limit);
  [[nodiscard]] bool is_allowed_here(const recorded::Partial& partial) const;
  void send_half_message(ReplayConnection& c, const recorded::Partial& partial);
  void forget(ReplayConnection& c);
  void restart_router();
  void finish();

  ReplayConnection* connection();
  void look_for_unexpected_closes();
  void collect_findings(ReplayConnection& c);
  void differs(const ReplayConnection& c, std::string expected, std::string got);
  void end(ReplayEnd how, std::string why);
  [[nodiscard]] bool is_at_end() const { return result_.end != ReplayEnd::kComplete; }

  const Recording& recording_;
  const ReplayOptions& options_;
  ReplayNetwork network_;
  const std::set<int> last_lines_of_silent_;
  Origins origins_;
  ReplayResult result_;
  const Line* line_ = nullptr;                     // the present line
  int sender_ = -1;                                // the connection that sent last
  std::optional<recorded::Partial> half_message_;  // from the line before
  std::map<int, std::string> closed_by_restart_;
  Time start_{};
  Duration behind_{0};  // delay of the replay behind the recorded times
};

ReplayResult Walk::run() {
  start_ = os::now();
  if (auto used = network_.use_router(options_.endpoint); !used)
    end(ReplayEnd::kGaveUp, used.error().message());
  for (const Line& line : recording_.lines) {
    if (is_at_end()) break;
    line_ = &line;
    network_.set_line(line.number);
    wait_for_moment(line);
    std::visit([&](const auto& event) { on(event); }, line.event);
    if (last_lines_of_silent_.contains(line.number)) {
      if (ReplayConnection* c = network_.find(line.conn)) {
        c->answers_lifesigns = false;
        c->may_be_closed = true;
      }
    }
    look_for_unexpected_closes();
    if (network_.is_stopped()) end(ReplayEnd::kStopped, "stopped");
    if (result_.differences.size() >= options_.differences_max)
      end(ReplayEnd::kGaveUp, "too many differences");
    if (!is_at_end()) ++result_.lines;
  }
  if (!is_at_end()) finish();
  for (const ReplayConnection* c : network_.all()) {
    result_.received_as_expected += c->inbox.matched();
  }
  result_.lifesigns_answered = network_.lifesigns_answered();
  result_.took = os::now() - start_;
  return std::move(result_);
}

void Walk::on(const recorded::Message& message) {
  const MessageView view = message.view();
  if (!message.to_router) {
    ReplayConnection* c = is_lifesign(view.header) ? nullptr : connection();
    if (c != nullptr) c->inbox.expect({line_, origins_.of_delivered(view)});
    return;
  }
  if (is_lifesign_answer(view.header)) return;
  settle();
  become_sender(line_->conn);
  ReplayConnection* c = connection();
  if (c == nullptr) return;
  if (!network_.send(*c, message.bytes))
    differs(*c, "the router accepts the message", "it is not accepted");
  ++result_.sent;
  if (!is_router_message(view.header)) {
    origins_.sent(line_->conn, view);
  } else if (view.header.type == router_command::kMailboxPurge) {
    network_.register_fence(*c);
  }
}

void Walk::on(const recorded::Connect&) {
  settle();
  fence_sender();
  ++result_.connections;
  auto opened = network_.open(line_->conn, line_->peer);
  if (!opened && !network_.is_stopped()) {
    result_.differences.push_back(
        {line_->number, line_->conn, line_->peer, "a connection", opened.error().message()});
  }
}

void Walk::on(const recorded::Partial& partial) {
  if (partial.to_router) half_message_ = partial;  // the close is the next line
}

void Walk::on(const recorded::Close& close) {
  const auto half_message = std::exchange(half_message_, std::nullopt);
  settle();
  if (closed_by_restart_.erase(line_->conn) != 0) return;
  if (half_message || sender_ != line_->conn) fence_sender();
  ReplayConnection* c = connection();
  if (c == nullptr) return;
  const bool passes_here = half_message && close.by_router && is_allowed_here(*half_message);
  if (passes_here) ++result_.left_out;
  if (half_message && !passes_here) send_half_message(*c, *half_message);
  if (!close.by_router || passes_here) {
    close_as_client(*c, close.reset);
  } else {
    const Duration at_once = std::min(kRefusalLimit, options_.answer_limit);
    wait_for_close_by_router(*c, half_message ? at_once : options_.silence_limit);
  }
  if (!network_.wait_for_gone(c->conn)) {
    differs(*c, "mailboxes gone after the close", "the router still delivers to them");
  }
  forget(*c);
}

void Walk::on(const recorded::Mark& mark) {
  if (options_.on_mark) options_.on_mark(*line_);
  if (is_restart(mark)) restart_router();
}

// A message that was too long for the recorded router, but is not for this one.
bool Walk::is_allowed_here(const recorded::Partial& partial) const {
  const std::span<const std::byte> bytes = partial.first_bytes;
  if (bytes.size() < kHeaderSize) return false;
  const std::uint32_t length = wire::decode_header(bytes.first<kHeaderSize>()).length;
  return length > kHeaderSize && length <= options_.message_max;
}

void Walk::send_half_message(ReplayConnection& c, const recorded::Partial& partial) {
  std::vector<std::byte> bytes = partial.first_bytes;
  bytes.resize(partial.size);
  c.may_be_closed = true;
  network_.send(c, bytes);
  c.unfenced = false;  // a fence would be read as the rest of the incomplete message
}

void Walk::wait_for_moment(const Line& line) {
  if (options_.pace <= 0) return;
  const Duration after_start{
      static_cast<Duration::rep>(static_cast<double>(Duration(line.time).count()) / options_.pace)};
  const Duration wait = start_ + behind_ + after_start - os::now();
  if (wait > Duration::zero()) network_.run_until([] { return false; }, wait);
}

// Waits for everything the recording has shown so far.
void Walk::settle() {
  const auto all = network_.all();
  const auto complete = [&] {
    for (const ReplayConnection* c : all) {
      if (c->inbox.is_waiting() && c->socket.is_there()) return false;
    }
    return true;
  };
  network_.run_until(complete);
  if (network_.is_stopped()) return;
  for (ReplayConnection* c : all) {
    c->inbox.give_up();
    collect_findings(*c);
  }
}

void Walk::become_sender(int conn) {
  if (conn != sender_) fence_sender();
  sender_ = conn;
}

// Ensures that the router has processed the messages of the last sender, even without answers.
void Walk::fence_sender() {
  ReplayConnection* c = network_.find(sender_);
  if (c == nullptr || !c->unfenced) return;
  if (network_.fence(*c) || !c->socket.is_there() || network_.is_stopped()) return;
  differs(*c, "a message to itself returns", "it does not return");
  end(ReplayEnd::kGaveUp, "the router does not deliver");
}

// Like the recorded close(), but this side continues to read, so that everything the router sends
// can be compared.
void Walk::close_as_client(ReplayConnection& c, bool reset) {
  c.may_be_closed = true;
  if (reset) {
    if (c.unfenced) network_.fence(c);
    c.socket.close_with_reset();
    return;
  }
  c.socket.shut_down_sending();
  if (!network_.run_until([&] { return !c.socket.is_there(); })) {
    differs(c, "the router closes the connection", "it keeps the connection");
  }
}

void Walk::wait_for_close_by_router(ReplayConnection& c, Duration limit) {
  const Time before = os::now();
  const bool closed = network_.run_until([&] { return !c.socket.is_there(); }, limit);
  if (!closed) differs(c, "closed by the router", "still open");
  if (options_.pace > 0) behind_ += os::now() - before;
}

void Walk::forget(ReplayConnection& c) {
  c.inbox.finish();
  collect_findings(c);
  result_.received_as_expected += c.inbox.matched();
  if (sender_ == c.conn) sender_ = -1;
  network_.remove(c.conn);
}

void Walk::restart_router() {
  if (!options_.restart) {
    finish();
    return end(ReplayEnd::kNeedsRestart, "the rest needs a restarted router");
  }
  settle();
  fence_sender();
  for (ReplayConnection* c : network_.all()) c->may_be_closed = true;
  const auto endpoint = options_.restart();
  if (!endpoint) return end(ReplayEnd::kGaveUp, endpoint.error().message());
  for (ReplayConnection* c : network_.all()) {
    if (!network_.run_until([&] { return !c->socket.is_there(); })) {
      differs(*c, "closed by the exit of the router", "still open");
    }
    closed_by_restart_[c->conn] = c->peer;
    forget(*c);
  }
  if (auto used = network_.use_router(*endpoint); !used)
    end(ReplayEnd::kGaveUp, used.error().message());
}

// A last fence on every connection ensures that everything the router sends has arrived.
void Walk::finish() {
  settle();
  for (ReplayConnection* c : network_.all()) {
    if (c->socket.is_there() && !c->may_be_closed) network_.fence(*c);
  }
  look_for_unexpected_closes();
  for (ReplayConnection* c : network_.all()) forget(*c);
}

// The connection of the line. Null: the router has closed it, which was reported.
ReplayConnection* Walk::connection() { return network_.find(line_->conn); }

void Walk::look_for_unexpected_closes() {
  for (ReplayConnection* c : network_.all()) {
    if (c->may_be_closed || c->socket.is_there()) continue;
    const bool nonsense = c->socket.peer() == MessageSocket::Peer::kNonsense;
    differs(*c, "an open connection", nonsense ? "an invalid header" : "closed by the router");
    forget(*c);
  }
}

void Walk::collect_findings(ReplayConnection& c) {
  for (const Inbox::Finding& finding : c.inbox.take_findings()) {
    Difference d{line_->number, c.conn, c.peer, "nothing", "nothing"};
    if (finding.got) {
      d.line = finding.got->line;
      d.got = describe(finding.got->message.view());
    }
    if (finding.expected) {
      d.line = finding.expected->line->number;
      d.expected = describe(std::get<recorded::Message>(finding.expected->line->event).view());
    }
    if (finding.out_of_order) d.got = "this message after one that was sent later";
    result_.differences.push_back(std::move(d));
  }
}

void Walk::end(ReplayEnd how, std::string why) {
  if (is_at_end()) return;
  result_.end = how;
  result_.end_reason = std::move(why);
}

void Walk::differs(const ReplayConnection& c, std::string expected, std::string got) {
  if (network_.is_stopped()) return;  // the waits were interrupted
  result_.differences.push_back(
      {line_->number, c.conn, c.peer, std::move(expected), std::move(got)});
}

}  // namespace

std::string Difference::to_string() const {
  return "line " + std::to_string(line) + ", connection " + std::to_string(conn) + " (" + peer +
         "): expected " + expected + "; got " + got;
}

std::string ReplayResult::summary() const {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(took).count();
  std::string text =
      std::to_string(lines) + " lines, " + std::to_string(connections) + " connections, " +
      std::to_string(sent) + " messages sent, " + std::to_string(received_as_expected) +
      " received as recorded, " + std::to_string(lifesigns_answered) + " lifesigns answered, " +
      std::to_string(differences.size()) + " differences, " + std::to_string(ms) + " ms";
  if (left_out > 0) text += ", " + std::to_string(left_out) + " too long messages left out";
  return end == ReplayEnd::kComplete ? text : text + "; ended early: " + end_reason;
}

ReplayResult replay(const Recording& recording, const ReplayOptions& options) {
  return Walk(recording, options).run();
}

}  // namespace tims::test

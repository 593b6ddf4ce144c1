// The connections of a replay and their event loop: sending, lifesigns, and checks that the router
// has processed what was sent.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/inbox.h"
#include "tests/support/message_socket.h"
#include "tests/support/replay.h"

namespace tims::test {

// One connection of the recording, to the router under test.
struct ReplayConnection {
  ReplayConnection(int number, std::string program, os::File file)
      : conn(number), peer(std::move(program)), socket(std::move(file)) {}

  // The mailbox that shows how far the router has processed the connection.
  [[nodiscard]] Address fence_address() const;

  int conn;
  std::string peer;
  MessageSocket socket;
  Inbox inbox;
  bool answers_lifesigns = true;
  bool may_be_closed = false;  // the router may close it without a difference
  bool unfenced = false;       // something was sent since the last fence
  std::uint64_t fences_sent = 0;
  std::uint64_t fences_seen = 0;
};

class ReplayNetwork {
 public:
  explicit ReplayNetwork(const ReplayOptions& options);
  ~ReplayNetwork();

  // Sets the router for new connections. Opens the probe (see wait_for_gone).
  Result<void> use_router(const std::string& endpoint);
  Result<ReplayConnection*> open(int conn, const std::string& peer);
  ReplayConnection* find(int conn);  // null when it is not open
  void remove(int conn);             // closes it; unread bytes are discarded
  [[nodiscard]] std::vector<ReplayConnection*> all();

  // Sets the present line, which is stored with every message that arrives.
  void set_line(int line) { line_ = line; }

  // Sends, and waits until the system has accepted all of it.
  bool send(ReplayConnection& c, std::span<const std::byte> bytes);
  // Registers the mailbox that fence() needs; purging removes it like all others.
  void register_fence(ReplayConnection& c);
  // Waits until the router has processed everything this connection sent. False: timeout.
  bool fence(ReplayConnection& c);
  // Waits until the router no longer knows the mailboxes of a connection.
  bool wait_for_gone(int conn);

  // Runs the connections until `done`; false: timeout, or the replay was stopped.
  bool run_until(const std::function<bool()>& done, Duration limit);
  bool run_until(const std::function<bool()>& done);  // with answer_limit
  [[nodiscard]] bool is_stopped() const { return stopped_; }

  [[nodiscard]] std::uint64_t lifesigns_answered() const { return lifesigns_answered_; }

 private:
  void run_once(Time deadline);
  void on_readable(ReplayConnection& c);
  void on_message(ReplayConnection& c, OwnedMessage message);
  bool ask_whether_gone(int conn);

  const ReplayOptions& options_;
  std::string endpoint_;
  std::map<int, std::unique_ptr<ReplayConnection>> connections_;
  std::unique_ptr<ReplayConnection> probe_;
  Address not_available_;  // the last mailbox the router reported NOT_AVAILABLE to the probe
  std::uint64_t lifesigns_answered_ = 0;
  int line_ = 0;
  bool stopped_ = false;
};

}  // namespace tims::test

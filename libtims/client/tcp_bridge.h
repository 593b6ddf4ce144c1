// Adapter between a session and a router that is reached over TCP. It uses the local protocol
// towards the session (wire/local_protocol.h), and the TCP protocol of an original client towards
// the router (wire/tcp_protocol.h). The session therefore implements only one protocol, and all
// messages use it.
//
// One thread, which ends when either connection ends, and then closes the other.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "client/tcp_client.h"
#include "os/client_memory.h"
#include "os/file.h"
#include "tims/address.h"
#include "tims/message.h"
#include "tims/result.h"
#include "wire/local_protocol.h"
#include "wire/tcp_protocol.h"

namespace tims::client {

// writer identity: no other process writes into the mailboxes
inline constexpr std::uint32_t kTcpWriter = 1;

class TcpBridge {
 public:
  struct Settings {
    std::string where;              // the router, for messages
    std::uint32_t message_max = 0;  // limit of the router, header included
    int priority = 0;               // real-time priority of the thread; 0: none
  };
  // `router`: connected, non-blocking. `session`: the other end of the session's socket.
  TcpBridge(TcpClient router, os::File session, Settings settings);
  TcpBridge(const TcpBridge&) = delete;
  TcpBridge& operator=(const TcpBridge&) = delete;
  ~TcpBridge();  // precondition: one of the connections is closed

 private:
  // An answer to the session that depends on replies of the router. The router replies in the order
  // of the requests.
  struct Asked {
    std::uint32_t request = 0;
    wire::Record answer;
    std::size_t missing = 0;  // number of replies to come
    bool undone = false;      // an Open that was refused: its other mailboxes are deleted again
  };

  void run();
  bool turn();

  // Towards the session.
  bool read_session();
  void on_record(std::uint32_t request, const wire::Record& record, std::vector<os::File> files);
  void open(std::uint32_t request, const wire::Open& message, std::vector<os::File> files);
  bool offer(std::uint64_t segment, std::vector<os::File> files);
  wire::Opened add_mailboxes(const wire::Open& message, std::vector<os::File> files);
  Result<void> add_mailbox(const wire::OpenEntry& entry, os::File waker);
  bool remove_mailbox(Address address);
  void close(std::uint32_t request, const wire::Close& message);
  void grant_uplink(std::uint32_t request);
  void on_router_reply(bool good);
  std::size_t settle(wire::Opened& opened);
  void answer(std::uint32_t request, const wire::Record& record, std::span<const int> files = {});

  // Towards the router.
  [[nodiscard]] AddressWidths widths() const { return router_.protocol().widths(); }
  bool write_router();
  bool take_sent(std::size_t bytes_max, int messages_max = std::numeric_limits<int>::max());
  bool read_router();
  void deliver(const Header& header, std::span<const std::byte> body);

  const Settings settings_;
  TcpClient router_;
  os::File session_;
  bool failed_ = false;  // the session no longer accepts records

  std::deque<Asked> asked_;
  os::ClientMemory memory_{kTcpWriter};
  // key: the session's segment number
  std::map<std::uint64_t, os::ClientMemory::SegmentId> offered_;
  std::map<Address, os::ClientMemory::Handle> mailboxes_;
  std::unique_ptr<os::Uplink> uplink_;
  bool more_ = false;  // the uplink may contain more

  std::thread thread_;  // last: it uses all members above
};

}  // namespace tims::client

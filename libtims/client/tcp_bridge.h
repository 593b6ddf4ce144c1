// Between a session and a router that is reached over TCP. Towards the session it speaks as the
// router of its host would (wire/local_protocol.h), towards the router as an original client does
// (wire/tcp_protocol.h): so a session knows one way only, and every message takes it.
//
// One thread, which ends with either of the two connections, and closes the other.
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
#include "os/file.h"
#include "os/shared_memory.h"
#include "os/uplink.h"
#include "shm/sender.h"
#include "tims/address.h"
#include "tims/message.h"
#include "tims/result.h"
#include "wire/local_protocol.h"
#include "wire/tcp_protocol.h"

namespace tims::client {

// The mailboxes of the session: what comes from the router is delivered here, in this process.

inline constexpr std::uint32_t kTcpWriter = 1;  // the only process that writes to them

class TcpMailboxes {
 public:
  Result<void> offer(std::uint64_t segment, const os::File& memfd);
  // `waker` may be none: a futex. kAddressInUse: another mailbox of this session has it.
  Result<void> add(const wire::OpenEntry& entry, os::File waker);
  bool remove(Address address);  // false: unknown

  // To the mailbox of its receiver, if it has room; what it does not take, it counts.
  void deliver(const Header& header, std::span<const std::byte> body);

 private:
  struct Segment {
    os::Mapping mapping;
    std::size_t mailboxes = 0;
  };
  struct Mailbox {
    std::uint64_t segment = 0;
    std::unique_ptr<shm::Sender> sender;
    os::File waker;
  };

  std::map<std::uint64_t, Segment> segments_;
  std::map<Address, Mailbox> mailboxes_;
};

class TcpBridge {
 public:
  struct Settings {
    std::string where;              // the router, for people
    std::uint32_t message_max = 0;  // that it takes, header included
    int priority = 0;               // real-time, of the thread; 0: none
  };
  // `router`: connected, non-blocking. `session`: the other end of the session's socket.
  TcpBridge(TcpClient router, os::File session, Settings settings);
  TcpBridge(const TcpBridge&) = delete;
  TcpBridge& operator=(const TcpBridge&) = delete;
  ~TcpBridge();  // one of the connections must be closed

 private:
  // An answer to the session for which the router has to say something first. The router answers
  // in the order of what it was asked.
  struct Asked {
    std::uint32_t request = 0;
    wire::Record answer;
    std::size_t missing = 0;  // of the router's words
    bool undone = false;      // an Open that was refused: its other mailboxes are given back
  };

  void run();
  bool turn();

  // Towards the session.
  bool read_session();
  void on_record(std::uint32_t request, const wire::Record& record, std::vector<os::File> files);
  void open(std::uint32_t request, const wire::Open& wish, std::vector<os::File> files);
  wire::Opened add_mailboxes(const wire::Open& wish, std::vector<os::File> files);
  void close(std::uint32_t request, const wire::Close& wish);
  void grant_uplink(std::uint32_t request);
  void on_router_word(bool good);
  std::size_t settle(wire::Opened& opened);
  void answer(std::uint32_t request, const wire::Record& record, std::span<const int> files = {});

  // Towards the router.
  [[nodiscard]] AddressWidths widths() const { return router_.protocol().widths(); }
  bool write_router();
  bool take_sent(std::size_t bytes_max, int messages_max = std::numeric_limits<int>::max());
  bool read_router();

  const Settings settings_;
  TcpClient router_;
  os::File session_;
  bool failed_ = false;  // the session takes no more

  std::deque<Asked> asked_;
  TcpMailboxes mailboxes_;
  std::unique_ptr<os::Uplink> uplink_;
  bool more_ = false;  // there may be more in the uplink

  std::thread thread_;  // last: it uses all of the above
};

}  // namespace tims::client

// Implementation of a session behind its handle: the connection to the router, the shared memory of
// its own mailboxes, and the routes to all others.
//
// A route determines where messages to an address go: directly into a mailbox of this host, or into
// the uplink, the router's mailbox for messages that this client cannot deliver itself. Finding a
// known route takes no lock. Routes and targets are not freed while the session exists, so a
// sending thread may use them without reference counts. The memory of a mailbox that is gone is
// released nevertheless (PeerSegment::retire).
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "client/router_link.h"
#include "os/shared_memory.h"
#include "os/wakeup.h"
#include "shm/sender.h"
#include "tims/session.h"

namespace tims {

namespace client {

// Shared memory of another client, with those of its mailboxes that this session uses.
class PeerSegment {
 public:
  PeerSegment(os::Mapping mapping, std::uint64_t inode)
      : mapping_(std::move(mapping)), inode_(inode) {}

  [[nodiscard]] std::span<std::byte> bytes() const { return mapping_.bytes(); }
  [[nodiscard]] std::uint64_t inode() const { return inode_; }
  void use(std::uint64_t offset) { offsets_.push_back(offset); }
  // Removes one mailbox; with the last one, the shared pages are released.
  void retire();
  [[nodiscard]] bool retired() const { return retired_ == offsets_.size(); }

 private:
  os::Mapping mapping_;
  std::uint64_t inode_;
  std::vector<std::uint64_t> offsets_;
  std::size_t retired_ = 0;
};

struct Target {
  Target(const shm::MailboxView& view, std::uint32_t writer, PeerSegment& in, std::uint64_t at)
      : sender(view, writer), segment(in), offset(at) {}
  shm::Sender sender;
  PeerSegment& segment;
  const std::uint64_t offset;  // offset in the segment
  bool uplink = false;
  os::File waker;  // doorbell of an uplink; none: a futex
  // Connection number when the router last confirmed this target.
  std::atomic<std::uint64_t> confirmed = 0;
};

struct Route {
  explicit Route(Address a) : address(a) {}
  const Address address;
  std::atomic<Target*> target = nullptr;
  std::atomic<Time::rep> next_check_ns = 0;  // of a target that is not confirmed yet
};

class RouteTable {
 public:
  RouteTable() { grow(64); }
  RouteTable(const RouteTable&) = delete;
  RouteTable& operator=(const RouteTable&) = delete;

  // Lock-free for an address that was looked up before.
  Route& get(Address address) {
    if (Route* known = find(*table_.load(std::memory_order_acquire), address)) return *known;
    return add(address);
  }

  // Removes the target of an address that was looked up before.
  void forget(Address address);

 private:
  struct Table {
    explicit Table(std::size_t size) : cells(size) {}
    std::vector<std::atomic<Route*>> cells;  // size is a power of two
  };
  static Route* find(const Table& table, Address address) {
    const std::size_t mask = table.cells.size() - 1;
    for (std::size_t i = std::hash<Address>{}(address) >> 32;; ++i) {
      Route* route = table.cells[i & mask].load(std::memory_order_acquire);
      if (route == nullptr || route->address == address) return route;
    }
  }
  Route& add(Address address);
  static void put(Table& table, Route* route);
  void grow(std::size_t size);

  std::atomic<Table*> table_ = nullptr;
  std::mutex mutex_;  // held for changes
  std::vector<std::unique_ptr<Table>> tables_;
  std::vector<std::unique_ptr<Route>> routes_;
};

}  // namespace client

// Shared memory of mailboxes that were opened together.
struct OwnSegment {
  struct Mailbox {
    Address address;
    std::uint64_t offset = 0;
    os::WakePair wake;  // none: a futex
    bool open = true;
  };
  std::uint64_t id = 0;
  os::File memfd;
  os::Mapping mapping;
  std::vector<Mailbox> mailboxes;
};

class SessionCore final : public std::enable_shared_from_this<SessionCore>,
                          private client::RouterLink::Listener {
 public:
  SessionCore(SessionOptions options, wire::Endpoint router);

  Result<void> connect();
  Result<std::shared_ptr<OwnSegment>> open(std::span<const MailboxOptions> options,
                                           const GoOn& go_on);
  void close(OwnSegment& segment, Address address);
  Result<void> flush(Time deadline);

  // Finds where messages to an address go. For an address that is new or closed, asks the router
  // and waits for its answer. A target that is not confirmed since the router was restarted is
  // looked up without waiting.
  Result<client::Target*> target_for(Address dest) {
    client::Route& route = routes_.get(dest);
    if (client::Target* known = known_target(route)) return known;
    return resolve(route);
  }
  // The same without waiting; null: the router would have to be asked.
  client::Target* known_target(Address dest) { return known_target(routes_.get(dest)); }
  // Call it after a message was put into the target.
  static void wake(const client::Target& target) {
    os::wake_owner(target.sender, {target.waker.get(), target.uplink});
  }

  [[nodiscard]] bool connected() const { return link_.connected(); }
  [[nodiscard]] wire::Welcome welcome() const { return link_.welcome(); }

 private:
  // RouterLink::Listener
  Result<void> greet(client::Greeting& greeting) override;
  void lost() override;
  void moved(Address address) override;
  void found(const wire::Found& found, client::Answer& answer) override;
  void event(SessionEvent::Kind kind, const std::string& text) override;

  Result<void> register_segment(OwnSegment& segment, const GoOn& go_on);
  Result<void> register_again(client::Greeting& greeting, OwnSegment& segment);
  Result<void> uplink_again(client::Greeting& greeting);
  enum class Answered : std::uint8_t { kNo, kYes };
  void withdraw(std::span<const Address> addresses, Answered answered = Answered::kYes);

  client::Target* known_target(client::Route& route) {
    client::Target* target = route.target.load(std::memory_order_acquire);
    if (target == nullptr || target->sender.closed()) return nullptr;
    if (target->confirmed.load(std::memory_order_relaxed) != link_.connection())
      return confirm(route, *target);
    return target;
  }
  Result<client::Target*> resolve(client::Route& route);
  client::Target* confirm(client::Route& route, client::Target& target);
  Result<client::Answer> ask(const wire::Record& question);
  Result<client::Target*> ask_for_route(client::Route& route, client::Target* old);
  bool has_uplink();

  // Precondition: resolve_mutex_ is held.
  Result<client::Target*> local_target(const wire::Found& found, client::Answer& answer,
                                       client::Target* old);
  Result<client::Target*> uplink_target(client::Answer& grant);
  Result<client::Target*> add_target(const os::File& memfd, std::uint64_t offset);
  void point(client::Route& route, client::Target* to);
  void retire(client::Target& target);
  void leave_uplink();
  void take_along(client::Target& from, client::Target& to);

  const SessionOptions options_;

  std::timed_mutex registering_mutex_;  // held while own mailboxes are registered with the router
  std::mutex own_mutex_;                // protects the members below
  std::vector<std::weak_ptr<OwnSegment>> own_;
  std::uint64_t last_segment_ = 0;

  client::RouteTable routes_;
  // protects the members below; never held while waiting
  std::mutex resolve_mutex_;
  std::map<std::uint64_t, client::PeerSegment*> peers_;  // by inode
  std::vector<std::unique_ptr<client::PeerSegment>> segments_;
  std::vector<std::unique_ptr<client::Target>> targets_;
  client::Target* uplink_ = nullptr;         // of this connection
  client::Target* former_uplink_ = nullptr;  // of a lost connection, with the messages left in it
  Time uplink_left_{};
  // messages not reported yet, because no lock is held for an event
  std::size_t not_taken_along_ = 0;
  std::atomic<bool> uplink_wanted_ = false;

  client::RouterLink link_;  // last: its thread uses all members above
};

}  // namespace tims

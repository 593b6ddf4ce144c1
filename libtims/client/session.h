// What a session is behind its handle: the router link, the shared memory of its own mailboxes,
// and the routes to everybody else's.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "client/route.h"
#include "client/router_link.h"
#include "os/shared_memory.h"
#include "os/uplink.h"
#include "os/wakeup.h"
#include "tims/session.h"

namespace tims {

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
  Result<std::shared_ptr<OwnSegment>> open(std::span<const MailboxOptions> options);
  void close(OwnSegment& segment, Address address);
  Result<void> flush(Time deadline);

  // Where messages to an address go, asking the router, and waiting for its answer, for one that is
  // new or closed. One not confirmed since the router was restarted is asked for without waiting.
  Result<client::Target*> target_for(Address dest) {
    client::Route& route = routes_.get(dest);
    client::Target* target = route.target.load(std::memory_order_acquire);
    if (target == nullptr || target->sender.closed()) return resolve(route);
    if (target->confirmed.load(std::memory_order_relaxed) != link_.connection())
      return confirm(route, *target);
    return target;
  }
  // After a message was put into the target.
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

  Result<void> register_segment(OwnSegment& segment);
  Result<void> register_again(client::Greeting& greeting, OwnSegment& segment);
  Result<void> uplink_again(client::Greeting& greeting);
  void withdraw(std::span<const Address> addresses);

  Result<client::Target*> resolve(client::Route& route);
  client::Target* confirm(client::Route& route, client::Target& target);
  Result<client::Answer> ask(const wire::Record& question);
  Result<client::Target*> ask_for_route(client::Route& route, client::Target* old);
  bool has_uplink();

  // With resolve_mutex_ held.
  Result<client::Target*> local_target(const wire::Found& found, client::Answer& answer,
                                       client::Target* old);
  Result<client::Target*> uplink_target(client::Answer& grant);
  Result<client::Target*> add_target(const os::File& memfd, std::uint64_t offset);
  void point(client::Route& route, client::Target* to);
  void retire(client::Target& target);
  void leave_uplink();
  void take_along(client::Target& from, client::Target& to);

  const SessionOptions options_;

  std::mutex registering_mutex_;  // held while the router is told of own mailboxes
  std::mutex own_mutex_;          // what follows
  std::vector<std::weak_ptr<OwnSegment>> own_;
  std::uint64_t last_segment_ = 0;

  client::RouteTable routes_;
  std::mutex resolve_mutex_;                             // what follows; never held while waiting
  std::map<std::uint64_t, client::PeerSegment*> peers_;  // by inode
  std::vector<std::unique_ptr<client::PeerSegment>> segments_;
  std::vector<std::unique_ptr<client::Target>> targets_;
  client::Target* uplink_ = nullptr;         // of this connection
  client::Target* former_uplink_ = nullptr;  // of a router that went away, with what waits in it
  Time uplink_left_{};
  std::size_t not_taken_along_ = 0;  // messages, not told of yet: no lock is held for that
  std::atomic<bool> uplink_wanted_ = false;

  client::RouterLink link_;  // last: its thread uses all of the above
};

}  // namespace tims

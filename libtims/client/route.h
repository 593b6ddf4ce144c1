// Where messages to an address go: straight into a mailbox of this host, or into the uplink, the
// router's mailbox for what this client cannot deliver itself.
//
// Finding a known route takes no lock. Routes and targets are never freed while the session lives,
// so a sending thread may use them without counting; the memory behind a dead mailbox is given
// back all the same (PeerSegment::retire).
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "os/file.h"
#include "os/shared_memory.h"
#include "shm/sender.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::client {

// Shared memory of another client, with the mailboxes of it that are in use here.
class PeerSegment {
 public:
  PeerSegment(os::Mapping mapping, std::uint64_t inode)
      : mapping_(std::move(mapping)), inode_(inode) {}

  [[nodiscard]] std::span<std::byte> bytes() const { return mapping_.bytes(); }
  [[nodiscard]] std::uint64_t inode() const { return inode_; }
  void use(std::uint64_t offset) { offsets_.push_back(offset); }
  // One mailbox less; with the last one the shared pages go.
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
  const std::uint64_t offset;  // in it
  bool uplink = false;
  os::File waker;  // an uplink's is its doorbell; none: a futex
  // The router connection that last confirmed it.
  std::atomic<std::uint64_t> confirmed = 0;
};

struct Route {
  explicit Route(Address a) : address(a) {}
  const Address address;
  std::atomic<Target*> target = nullptr;
  std::atomic<Time::rep> next_check_ns = 0;  // of a target not confirmed yet
};

class RouteTable {
 public:
  RouteTable() { grow(64); }
  RouteTable(const RouteTable&) = delete;
  RouteTable& operator=(const RouteTable&) = delete;

  // Lock-free for an address that was asked for before.
  Route& get(Address address) {
    if (Route* known = find(*table_.load(std::memory_order_acquire), address)) return *known;
    return add(address);
  }

  // Forgets the target of one address, if it was asked for before.
  void forget(Address address);

 private:
  struct Table {
    explicit Table(std::size_t size) : cells(size) {}
    std::vector<std::atomic<Route*>> cells;  // power of two
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
  std::mutex mutex_;  // of changes
  std::vector<std::unique_ptr<Table>> tables_;
  std::vector<std::unique_ptr<Route>> routes_;
};

}  // namespace tims::client

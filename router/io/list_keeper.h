// Verifies the lists of the fleet that other routers send, and stores them in the folder of keys:
// in a thread of its own, because signatures and disks take milliseconds.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <boost/asio/thread_pool.hpp>

#include "router/link/list_exchange.h"
#include "security/keys/key_folder.h"

namespace tims::io {

struct CheckedList {
  std::uint64_t transfer = 0;
  std::uint64_t number = 0;
  std::string from{};     // the name of the router that has sent it
  std::string refused{};  // why; empty: the list is good
  std::shared_ptr<const security::FleetList> list{};
  security::Bytes bytes{};
  std::string not_stored{};  // why; empty: it lies in the folder of keys
};

class ListKeeper final : public link::ListKeeper {
 public:
  // `report` is called in the other thread.
  using Report = std::function<void(CheckedList&&)>;
  ListKeeper(security::KeyFolder folder, Report report);
  ListKeeper(const ListKeeper&) = delete;
  ListKeeper& operator=(const ListKeeper&) = delete;
  ~ListKeeper() override;

  // Whose signatures are believed from now on. Before the first call no list is good.
  void set_credentials(const security::Credentials& credentials);

  void check(std::uint64_t transfer, std::uint64_t number, std::string_view from,
             std::vector<std::byte>&& bytes) override;

 private:
  struct Believed {
    std::vector<security::Certificate> roots;
    std::string fleet;
  };
  void judge(CheckedList& list, const Believed& believed) const;

  security::KeyFolder folder_;
  Report report_;
  std::shared_ptr<const Believed> believed_ = std::make_shared<Believed>();
  boost::asio::thread_pool thread_{1};  // the last member: it uses the others
};

}  // namespace tims::io

#include "router/io/list_keeper.h"

#include <utility>

#include <boost/asio/post.hpp>

namespace tims::io {

static_assert(link::ListExchange::kBytesMax == security::FleetList::kBytesMax);

ListKeeper::ListKeeper(security::KeyFolder folder, Report report)
    : folder_(std::move(folder)), report_(std::move(report)) {}

ListKeeper::~ListKeeper() {
  thread_.stop();
  thread_.join();
}

void ListKeeper::set_credentials(const security::Credentials& credentials) {
  believed_ =
      std::make_shared<const Believed>(Believed{credentials.roots, credentials.identity.fleet});
}

void ListKeeper::check(std::uint64_t transfer, std::uint64_t number, std::string_view from,
                       std::vector<std::byte>&& bytes) {
  CheckedList list{
      .transfer = transfer, .number = number, .from = std::string(from), .bytes = std::move(bytes)};
  boost::asio::post(thread_, [this, list = std::move(list), believed = believed_]() mutable {
    judge(list, *believed);
    report_(std::move(list));
  });
}

// A list that cannot be stored counts all the same: a full disk protects nobody who is revoked.
void ListKeeper::judge(CheckedList& list, const Believed& believed) const {
  auto opened = security::FleetList::open(list.bytes, believed.roots, believed.fleet);
  if (!opened) {
    list.refused = opened.error().detail();
    return;
  }
  if (opened->number != list.number) {
    list.refused = "it has the number " + std::to_string(opened->number) + ", not the promised " +
                   std::to_string(list.number);
    return;
  }
  list.list = std::make_shared<const security::FleetList>(std::move(*opened));
  const auto stored = folder_.take_over_list(list.bytes);
  if (!stored) list.not_stored = stored.error().detail();
}

}  // namespace tims::io

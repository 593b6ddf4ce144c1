#include "router/io/list_keeper.h"

#include <utility>

namespace tims::io {

static_assert(link::ListExchange::kBytesMax == security::FleetList::kBytesMax);

ListKeeper::ListKeeper(security::KeyFolder folder, Report report)
    : folder_(std::move(folder)), report_(std::move(report)), thread_([this] { run(); }) {}

ListKeeper::~ListKeeper() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wakes_.notify_one();
  thread_.join();
}

void ListKeeper::set_credentials(const security::Credentials& credentials) {
  believed_ =
      std::make_shared<const Believed>(Believed{credentials.roots, credentials.identity.fleet});
}

void ListKeeper::check(std::uint64_t transfer, std::uint64_t number, std::string_view from,
                       std::vector<std::byte>&& bytes) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back({.list = {.transfer = transfer,
                              .number = number,
                              .from = std::string(from),
                              .bytes = std::move(bytes)},
                     .believed = believed_});
  }
  wakes_.notify_one();
}

void ListKeeper::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wakes_.wait(lock, [this] { return ends_ || !jobs_.empty(); });
    if (ends_) return;
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    work(job);
    report_(std::move(job.list));
    lock.lock();
  }
}

// A list that cannot be stored counts all the same: a full disk protects nobody who is revoked.
void ListKeeper::work(Job& job) const {
  CheckedList& list = job.list;
  auto opened = security::FleetList::open(list.bytes, job.believed->roots, job.believed->fleet);
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

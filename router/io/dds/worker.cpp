#include "router/io/dds/worker.h"

#include <algorithm>
#include <stdexcept>

#include "os/clock.h"
#include "router/io/dds/library_log.h"
#include "router/link/bundle.h"

namespace tims::io {
namespace {

using namespace std::chrono_literals;

constexpr Duration kReaderLimit = 2s;     // for the receiver to appear
constexpr Duration kFinishLimit = 200ms;  // for the last words
constexpr Duration kPatienceMin = 100us;
constexpr Duration kPatienceMax = 2ms;

}  // namespace

DdsWorker::DdsWorker(const DdsSettings& settings, eprosima::fastdds::dds::DomainParticipantQos qos,
                     std::shared_ptr<DdsNews> news, std::shared_ptr<DdsOrders> orders)
    : settings_(settings),
      qos_(std::move(qos)),
      news_(std::move(news)),
      orders_(std::move(orders)) {}

void DdsWorker::run() {
  send_library_log_to(news_);
  DdsOrders::Wanted wanted;
  Time look_again = kNever;
  for (;;) {
    const bool changed = orders_->wait(look_again, wanted);
    if (wanted.end) break;
    // Exceptions are the library's. What it has begun stays until another life is wanted.
    look_again = guarded([&] {
      if (changed) obey(wanted);
      return serve(os::now());
    });
  }
  guarded([&] { return finish(wanted); });
  routes_.clear();
  participant_.reset();
}

template <typename Work>
Time DdsWorker::guarded(Work work) {
  try {
    return work();
  } catch (const std::exception& e) {
    news_->has_failed({life_, e.what()});
    return kNever;
  }
}

// What waits is written, and has arrived, unless that takes too long.
Time DdsWorker::finish(DdsOrders::Wanted& wanted) {
  const Time limit = os::now() + kFinishLimit;
  for (Time next = serve(os::now()); next < limit; next = serve(os::now()))
    orders_->wait(next, wanted);
  for (auto& [address, route] : routes_) {
    if (route.writer) route.writer->wait_until_arrived(limit - os::now());
  }
  return kNever;
}

void DdsWorker::obey(const DdsOrders::Wanted& wanted) {
  if (wanted.life != life_) live(wanted);
  keep_routes(wanted);
}

void DdsWorker::live(const DdsOrders::Wanted& wanted) {
  for (auto& [address, route] : routes_) route.writer.reset();
  participant_.reset();
  life_ = wanted.life;
  participant_ = std::make_unique<DdsParticipant>(settings_, qos_, wanted, news_, orders_);
  news_->is_up({life_, participant_->address(), participant_->reader()});
}

void DdsWorker::keep_routes(const DdsOrders::Wanted& wanted) {
  std::map<link::NetAddress, Route> kept;
  for (const auto& peer : wanted.peers) {
    auto known = routes_.extract(peer->address);
    if (known && known.mapped().peer == peer) {
      kept.insert(std::move(known));
    } else {
      kept.emplace(peer->address, Route{.peer = peer});
    }
  }
  routes_ = std::move(kept);
  if (!participant_) return;
  for (auto& [address, route] : routes_) {
    if (!route.writer) route.writer = participant_->make_writer(route.peer);
  }
}

Time DdsWorker::serve(Time now) {
  Time look_again = kNever;
  for (auto& [address, route] : routes_) look_again = std::min(look_again, serve(now, route));
  return look_again;
}

// One sample at a time: then the others have their turn.
Time DdsWorker::serve(Time now, Route& route) {
  SendQueue& queue = route.peer->queue;
  if (!route.writer || !route.peer->matched) return wait_for_reader(now, route);
  route.waits_since = kNever;
  if (now < route.again_at) return route.again_at;
  const SendQueue::Front front = queue.front(kSampleBytesMax);
  if (front.bytes == 0) return kNever;
  const Written written = route.writer->write(front);
  if (written == Written::kNever) throw std::runtime_error("a sample could not be written");
  if (written == Written::kNotNow) {
    route.patience = std::clamp(2 * route.patience, kPatienceMin, kPatienceMax);
    return route.again_at = now + route.patience;
  }
  route.patience = {};
  queue.remove(front);
  orders_->written.samples += 1;
  orders_->written.datagrams += front.datagrams;
  orders_->written.bytes += front.bytes - front.datagrams * link::kBundleSizeBytes;
  return now;  // there may be more
}

Time DdsWorker::wait_for_reader(Time now, Route& route) {
  SendQueue& queue = route.peer->queue;
  if (queue.waiting_bytes() == 0) {
    route.waits_since = kNever;
    return kNever;
  }
  if (route.waits_since == kNever) route.waits_since = now;
  if (now < route.waits_since + kReaderLimit) return route.waits_since + kReaderLimit;
  const SendQueue::Front all = queue.front(SendQueue::kBytes);
  queue.remove(all);
  orders_->written.unmatched += all.datagrams;
  route.waits_since = kNever;
  return kNever;
}

}  // namespace tims::io

#include "router/io/dds/worker.h"

#include <algorithm>

#include "router/io/dds/library_log.h"

namespace tims::io {

DdsWorker::DdsWorker(const DdsSettings& settings,
                     const eprosima::fastdds::dds::DomainParticipantQos& qos,
                     std::shared_ptr<DdsNews> news, std::shared_ptr<DdsOrders> orders)
    : settings_(settings), qos_(qos), news_(std::move(news)), orders_(std::move(orders)) {}

void DdsWorker::run() {
  send_library_log_to(news_);
  for (DdsOrders::Wanted wanted = orders_->wait(); !wanted.end; wanted = orders_->wait()) {
    // Exceptions are the library's. What it has begun stays until another life is wanted.
    try {
      obey(wanted);
    } catch (const std::exception& e) {
      news_->has_failed({life_, e.what()});
    }
  }
  writers_.clear();
  participant_.reset();
}

void DdsWorker::obey(const DdsOrders::Wanted& wanted) {
  if (wanted.life != life_) live(wanted);
  keep_writers(wanted);
}

void DdsWorker::live(const DdsOrders::Wanted& wanted) {
  writers_.clear();
  participant_.reset();
  life_ = wanted.life;
  participant_ = std::make_unique<DdsParticipant>(settings_, qos_, wanted, news_);
  news_->is_up({life_, participant_->address(), participant_->reader()});
}

void DdsWorker::keep_writers(const DdsOrders::Wanted& wanted) {
  std::erase_if(writers_, [&](const auto& writer) {
    return std::ranges::find(wanted.peers, writer.first) == wanted.peers.end();
  });
  if (!participant_) return;
  for (const auto& peer : wanted.peers) {
    if (writers_.contains(peer)) continue;
    const auto made = writers_.emplace(peer, participant_->make_writer(peer)).first;
    news_->has_opened({life_, peer, made->second.get()});
  }
}

}  // namespace tims::io

#include "router/io/dds/library_log.h"

#include <fastdds/dds/log/Log.hpp>

namespace tims::io {
namespace {

using eprosima::fastdds::dds::Log;
using eprosima::fastdds::dds::LogConsumer;

class Consumer final : public LogConsumer {
 public:
  explicit Consumer(std::weak_ptr<DdsNews> news) : news_(std::move(news)) {}

  // In the library's own thread.
  void Consume(const Log::Entry& entry) override {
    const auto news = news_.lock();
    if (!news) return;
    const char* category = entry.context.category != nullptr ? entry.context.category : "";
    news->has_said({.error = entry.kind == Log::Kind::Error,
                    .text = std::string(category) + ": " + entry.message});
  }

 private:
  const std::weak_ptr<DdsNews> news_;
};

}  // namespace

void send_library_log_to(const std::shared_ptr<DdsNews>& news) {
  Log::ClearConsumers();
  Log::SetVerbosity(Log::Kind::Warning);
  Log::RegisterConsumer(std::make_unique<Consumer>(news));
}

}  // namespace tims::io

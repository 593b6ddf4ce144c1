#include "router/core/missing_routers.h"

namespace tims::core {

void MissingRouters::add(MissingRouter missing) {
  const auto is_over = [&](const MissingRouter& other) {
    return missing.since >= other.since + kMissingRouterKept;
  };
  while (!list_.empty() && (list_.size() == kMissingRoutersMax || is_over(list_.front())))
    list_.pop_front();
  missing.number = ++numbers_;
  list_.push_back(missing);
}

void MissingRouters::found(Address router) {
  std::erase_if(list_, [&](const MissingRouter& missing) { return missing.router == router; });
}

}  // namespace tims::core

#include "router/io/http/asio_guest.h"

#include <utility>

namespace tims::io {
namespace {

constexpr int kHandlersPerTurn = 64;  // before others have their turn

}  // namespace

void AsioGuest::wake() {
  if (std::exchange(awake_, true)) return;
  loop_.post([this] { run(); });
}

void AsioGuest::run() {
  int n = 0;
  while (n < kHandlersPerTurn && context_.poll_one() > 0) ++n;
  awake_ = false;
  if (n == kHandlersPerTurn) wake();
}

}  // namespace tims::io

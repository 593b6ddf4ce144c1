#include "router/io/renewal.h"

#include <memory>

#include <fmt/core.h>

#include "os/clock.h"

namespace tims::io {

void Renewal::on_timeout(Time now) {
  if (now < next_) return;
  next_ = now + kTryEvery;
  if (runs_ || !steps_.is_due()) return;
  runs_ = true;
  thread_ = std::jthread([this, now, renew = steps_.prepare()] {
    auto renewed =
        std::make_shared<Result<security::Identity>>(renew(os::deadline_after(kPatience)));
    loop_.post([this, now, renewed] { on_result(now, *renewed); });
  });
}

void Renewal::on_result(Time began, const Result<security::Identity>& renewed) {
  runs_ = false;
  if (renewed) return log_.info("renewed the certificate of " + renewed->to_string());
  if (began < next_log_) return;
  next_log_ = began + kLogEvery;
  log_.always(
      config::LogLevel::kWarning,
      fmt::format("the certificate of this router is due to be renewed: {}; it stays in use, and "
                  "this is tried each hour (timsctl key serve on the base, timsctl key renew here)",
                  renewed.error().detail()));
}

}  // namespace tims::io

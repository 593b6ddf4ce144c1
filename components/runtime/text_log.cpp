#include "rack/text_log.h"

#include <array>
#include <cstdio>
#include <mutex>
#include <utility>

#include "base/rate_limiter.h"
#include "components/runtime/log_text.h"
#include "os/file.h"
#include "os/wakeup.h"
#include "rack/priority_mutex.h"

namespace rack {

namespace {

struct QueuedText {
  gdos::Level level{};
  std::uint16_t size = 0;
  gdos::Body body{};
};
constexpr std::size_t kTextLogRing = 64;

// Limits the rate of texts.
constexpr std::uint64_t kTextsPerSecond = 10;
constexpr std::uint64_t kBurst = 50;

QueuedText queued_text(gdos::Level level, fmt::string_view format, fmt::format_args arguments) {
  QueuedText text{.level = level};
  text.size = static_cast<std::uint16_t>(log_text(text.body, format, arguments));
  return text;
}

void pass_on_one(const QueuedText& text, tims::Mailbox& mailbox) {
  const auto body = std::span(text.body).first(text.size);
  const auto widths = mailbox.address_widths();
  // Texts have the lowest priority, and there may be no receiver.
  (void)mailbox.send({.dest = tims::text_sink(widths),
                      .type = static_cast<std::int8_t>(text.level),
                      .priority = 0},
                     body);
  const auto line = gdos::decode(body, std::endian::native, widths);
  std::fprintf(stderr, "%s %s: %s\n", mailbox.address().to_string(widths).c_str(),
               std::string(gdos::name(text.level)).c_str(),
               (line ? *line : line.error().detail()).c_str());
}

void report_suppressed(tims::Mailbox& mailbox, std::uint32_t count) {
  pass_on_one(queued_text(gdos::Level::kWarning, "{} texts suppressed: too many at once",
                          fmt::make_format_args(count)),
              mailbox);
}

}  // namespace

struct TextLog::Ring {
  bool take(QueuedText& text) {
    const std::lock_guard lock(mutex);
    if (count == 0) return false;
    text = texts[first];
    first = (first + 1) % kTextLogRing;
    --count;
    return true;
  }

  tims::os::File doorbell;
  tims::base::LineLimiter limiter{kTextsPerSecond, kBurst};  // the main thread
  PriorityMutex mutex;                                       // protects the members below
  std::array<QueuedText, kTextLogRing> texts;
  std::size_t first = 0;
  std::size_t count = 0;
  std::uint32_t lost = 0;  // the ring was full
};

TextLog::TextLog(gdos::Level threshold) : threshold_(threshold), ring_(std::make_unique<Ring>()) {
  // Without the doorbell, texts are sent a little later.
  if (auto doorbell = tims::os::make_event_fd()) ring_->doorbell = std::move(*doorbell);
}

TextLog::~TextLog() = default;

int TextLog::descriptor() const { return ring_->doorbell.get(); }

void TextLog::queue(gdos::Level level, fmt::string_view format, fmt::format_args arguments) {
  if (level < threshold_.load(std::memory_order_relaxed)) return;
  const QueuedText text = queued_text(level, format, arguments);
  {
    const std::lock_guard lock(ring_->mutex);
    if (ring_->count == kTextLogRing) {
      ++ring_->lost;
      return;
    }
    ring_->texts[(ring_->first + ring_->count) % kTextLogRing] = text;
    ++ring_->count;
  }
  if (ring_->doorbell) tims::os::signal_event_fd(ring_->doorbell.get());
}

void TextLog::pass_on(tims::Time now, tims::Mailbox& mailbox) {
  if (ring_->doorbell) tims::os::drain_event_fd(ring_->doorbell.get());
  QueuedText text;
  while (ring_->take(text)) {
    if (!ring_->limiter.take(now)) continue;
    if (const std::uint32_t held_back = ring_->limiter.take_held_back())
      report_suppressed(mailbox, held_back);
    pass_on_one(text, mailbox);
  }
  std::uint32_t lost = 0;
  {
    const std::lock_guard lock(ring_->mutex);
    lost = std::exchange(ring_->lost, 0);
  }
  if (lost > 0) report_suppressed(mailbox, lost);
}

}  // namespace rack

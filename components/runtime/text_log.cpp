#include "rack/text_log.h"

#include <cstdio>

#include "os/wakeup.h"

namespace rack {

TextLog::TextLog(gdos::Level threshold) : threshold_(threshold) {
  // Without it texts are passed on a little later.
  if (auto doorbell = tims::os::make_event_fd()) doorbell_ = std::move(*doorbell);
}

void TextLog::write(gdos::Level level, std::string_view format,
                    std::initializer_list<gdos::Argument> arguments) {
  if (level < threshold_.load(std::memory_order_relaxed)) return;
  {
    const std::lock_guard lock(mutex_);
    if (count_ == kRing) {
      ++lost_;
      return;
    }
    Text& text = ring_[(first_ + count_) % kRing];
    text.level = level;
    text.size = static_cast<std::uint16_t>(
        gdos::encode(text.body, format, std::span(arguments.begin(), arguments.size())));
    ++count_;
  }
  if (doorbell_) tims::os::signal_event_fd(doorbell_.get());
}

void TextLog::pass_on(tims::Time now, tims::Mailbox& mailbox) {
  if (doorbell_) tims::os::drain_event_fd(doorbell_.get());
  Text text;
  while (take(text)) {
    if (!limiter_.take(now)) continue;
    if (const std::uint32_t kept_back = limiter_.take_suppressed())
      say_suppressed(mailbox, kept_back);
    pass_on(text, mailbox);
  }
  std::uint32_t lost = 0;
  {
    const std::lock_guard lock(mutex_);
    lost = std::exchange(lost_, 0);
  }
  if (lost > 0) say_suppressed(mailbox, lost);
}

bool TextLog::take(Text& text) {
  const std::lock_guard lock(mutex_);
  if (count_ == 0) return false;
  text = ring_[first_];
  first_ = (first_ + 1) % kRing;
  --count_;
  return true;
}

void TextLog::say_suppressed(tims::Mailbox& mailbox, std::uint32_t count) {
  Text text{.level = gdos::Level::kWarning};
  const gdos::Argument argument(count);
  text.size = static_cast<std::uint16_t>(
      gdos::encode(text.body, "%d texts suppressed: too many at once", {&argument, 1}));
  pass_on(text, mailbox);
}

void TextLog::pass_on(const Text& text, tims::Mailbox& mailbox) {
  const auto body = std::span(text.body).first(text.size);
  // Texts are the least important of all, and nobody may be there to read them.
  (void)mailbox.send(
      {.dest = gdos::kSink, .type = static_cast<std::int8_t>(text.level), .priority = 0}, body);
  const auto widths = mailbox.address_widths();
  const auto words = gdos::decode(body, std::endian::native, widths);
  std::fprintf(stderr, "%s %s: %s\n", mailbox.address().to_string(widths).c_str(),
               std::string(gdos::name(text.level)).c_str(),
               (words ? *words : words.error().detail()).c_str());
}

}  // namespace rack

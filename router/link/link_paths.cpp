// Link, the part that goes over several ways.
#include <array>

#include "router/link/link.h"

namespace tims::link {

void Link::configure(Time now, const LinkSettings& settings) {
  settings_ = settings;
  session_.configure(settings.session);
  exchange_.set_mailboxes_max(settings.mailboxes_max);
  const PathKind before = paths_.kind();
  if (paths_.configure(now, settings.paths, settings.keep_alive) && is_up())
    go_elsewhere(now, before);
}

void Link::watch_paths(Time now) {
  const Duration rtt = session_.rtt().smoothed();
  const PathKind before = paths_.kind();
  if (paths_.on_timeout(now, rtt)) go_elsewhere(now, before);
  paths_.ask(
      now, rtt, [&] { return around_.random(); },
      [&](const Paths::Question& question) {
        send_nonce(now, FrameType::kChallenge, question.nonce, question.to);
      });
}

void Link::send_nonce(Time now, FrameType type, std::uint64_t nonce, const NetAddress& to) {
  std::array<std::byte, kDataHeaderSize + kNonceFrameSize> bytes{};
  const std::size_t size = session_.build_nonce(now, their_token_, type, nonce, bytes);
  paths_.count_out(to.kind, size);
  around_.send(to, std::span(bytes).first(size));
}

void Link::on_frame(Time now, const ChallengeFrame& frame) {
  // A way that is not prepared yet: an answer would, and many may ask at once.
  if (paths_.leads(from_.kind)) send_nonce(now, FrameType::kResponse, frame.nonce, from_);
  // What comes this way may not go back this way.
  if (from_.kind != paths_.kind())
    send_nonce(now, FrameType::kResponse, frame.nonce, paths_.address());
}

void Link::on_frame(Time now, const ResponseFrame& frame) {
  const PathKind before = paths_.kind();
  if (is_up() && paths_.on_answer(now, from_, frame.nonce)) go_elsewhere(now, before);
}

// The other router is where paths_ says: what was on its way is sent again, there.
void Link::go_elsewhere(Time now, PathKind before) {
  session_.on_new_path(now, paths_.kind());
  next_keep_alive_ = now;
  if (paths_.kind() == before) return;
  router_.note({.at = now,
                .kind = core::EventKind::kLinkPath,
                .client = {.id = client_,
                           .port = core::PortKind::kLink,
                           .name = core::Text<31>(peer_.name.view()),
                           .peer = std::string_view(address().to_string())},
                .text = std::string_view(std::string(name(before)) + " to " +
                                         std::string(name(paths_.kind())) + ": " + paths_.why())});
}

}  // namespace tims::link

#include "tools/evaluation/dora/ears.h"

#include <algorithm>

#include "os/clock.h"
#include "rack/proxies/proxy.h"
#include "rack/proxies/world.h"
#include "tools/cli/failure.h"
#include "tools/evaluation/dora/reference.h"

namespace rack::dora {
namespace {

using namespace std::chrono_literals;

constexpr int kPriority = 90;
constexpr std::uint32_t kLargest = 256U << 10;
constexpr Duration kAskAgain = 300ms;
constexpr Duration kLook = 100ms;  // whether it shall end

tims::Session connect(const std::string& socket) {
  return timsctl::value_or_fail(
      tims::Session::connect({.name = "rack-dora",
                              .router = socket,
                              .timeout = 10s,
                              .on_event = [](const tims::SessionEvent&) {}}),
      socket);
}

tims::Mailbox open_at(tims::Session& session, tims::MailboxOptions options) {
  const auto widths = session.address_widths();
  const std::uint32_t system = session.router().fields(widths).system;
  for (int taken = 1;; ++taken) {
    options.address = timsctl::mailbox_address({}, system, widths);
    auto mailbox = session.open(options);
    if (mailbox) return std::move(*mailbox);
    if (mailbox.error().code() != tims::Errc::kAddressInUse || !timsctl::may_draw_again({}, taken))
      throw timsctl::failure_of(mailbox.error(), "a mailbox");
  }
}

}  // namespace

tims::Address address_of(std::string_view component) {
  constexpr std::string_view kOfWorld = "World(";  // no class of the original
  if (component.starts_with(kOfWorld)) return tims::Address::of({.system = 1, .class_id = kWorld});
  const auto address = tims::Address::parse(component);
  if (!address)
    throw timsctl::usage_error(std::string(component) + " is no address of a component");
  return *address;
}

Ears::Ears(std::string_view host, const std::string& socket, Hear hear)
    : hear_(std::move(hear)), session_(connect(socket)) {
  work_.emplace(open({.slots = 16, .body_max = 1U << 20}));
  stream_.emplace(open({.slots = 256, .body_max = kLargest}));
  for (std::size_t i = 0; i < kStreams.size(); ++i) {
    if (kStreams.at(i).host != host) continue;
    auto heard = std::make_unique<Heard>();
    heard->stream = i;
    heard->component = address_of(kStreams.at(i).component);
    const auto period = std::chrono::duration<double, std::milli>(kStreams.at(i).period_ms);
    heard->patience = std::max(kAskAgain, std::chrono::duration_cast<Duration>(period) * 5 / 2);
    heard_.push_back(std::move(heard));
  }
  const std::string name = std::string("ears ") + std::string(host.substr(host.find('-') + 1));
  real_time_ = start_thread(thread_, name, kPriority, [this] { listen(); });
}

Ears::~Ears() {
  ending_ = true;
  thread_.join();
}

tims::Mailbox Ears::open(const tims::MailboxOptions& options) { return open_at(session_, options); }

void Ears::listen() {
  while (!ending_) {
    const auto message = stream_->peek_for(kLook);
    if (!message) continue;
    const Time now = tims::os::now();
    const tims::MessageView view{message->header(), message->body()};
    const auto from = std::ranges::find_if(
        heard_, [&](const auto& heard) { return heard->component == view.header.src; });
    if (from == heard_.end()) continue;
    (*from)->last = now.time_since_epoch().count();
    if (view.header.type == tims::type::kData || view.header.type == tims::type::kError)
      hear_((*from)->stream, view, now);
  }
}

void Ears::keep() {
  for (const auto& heard : heard_) {
    const Time now = tims::os::now();
    const Time last{Duration(heard->last.load())};
    if (now - std::max(last, heard->asked) < heard->patience) continue;
    heard->asked = now;
    Proxy proxy(*work_, heard->component);
    (void)proxy.get_cont_data(0, stream_->address());
  }
}

}  // namespace rack::dora

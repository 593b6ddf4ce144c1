// The doctor's part for links to other routers.
#include <cmath>

#include <fmt/format.h>

#include "tools/timsctl/findings.h"
#include "tools/timsctl/humanize.h"

namespace timsctl {

namespace {

constexpr double kLossMax = 0.05;
constexpr double kClockOffsetMax_s = 0.1;
// The size of datagrams is found within a moment; what is still the smallest then stays so.
constexpr double kMtuFoundAfter_s = 10;
constexpr double kMtuBase = 1200;

class LinkDoctor {
 public:
  explicit LinkDoctor(const Facts& facts) : facts_(facts) {}

  std::vector<Finding> examine() {
    socket();
    for (const json::value& value : facts_.links) {
      const json::object& link = value.as_object();
      if (text_at(link, "state") == "up")
        working(link);
      else
        not_up(link);
    }
    if (findings_.empty() && !facts_.links.empty())
      add("links", Level::kOk,
          fmt::format("{} link{} up", facts_.links.size(),
                      facts_.links.size() == 1 ? " is" : "s are"));
    event("duplicate_router", "routers.duplicate", "a second router had the id of another one");
    event("duplicate_address", "addresses.duplicate",
          "a mailbox was announced whose address another router has");
    event("loop", "routes.loop", "messages or registrations went round in a loop");
    return std::move(findings_);
  }

 private:
  void add(const char* id, Level level, std::string text, std::string hint = {}) {
    findings_.push_back(make_finding(id, level, std::move(text), std::move(hint)));
  }

  void socket() {
    const double asked = number_or_zero(facts_.status, "udp.asked_buffer_bytes");
    const double in = number_or_zero(facts_.status, "udp.receive_buffer_bytes");
    const double out = number_or_zero(facts_.status, "udp.send_buffer_bytes");
    const double dropped = number_or_zero(facts_.status, "udp.dropped_by_kernel");
    if (asked == 0 || facts_.links.empty() || std::min(in, out) >= asked) return;
    std::string text = fmt::format(
        "the links' socket buffers {} in and {} out, less than the {} "
        "asked for: bursts may be lost",
        human_bytes(in), human_bytes(out), human_bytes(asked));
    if (dropped > 0) text += fmt::format("; {} datagrams were", human_count(dropped));
    add("sockets.udp", dropped > 0 ? Level::kWarning : Level::kInfo, std::move(text));
  }

  static std::string name_of(const json::object& link) {
    const std::string name = text_at(link, "via");
    const std::string address = text_at(link, "peer_address");
    const std::string text = name.empty() || name == address ? address : name;
    return printable(fmt::format("{} ({})", text.empty() ? "?" : text, text_at(link, "kind")));
  }

  void not_up(const json::object& link) {
    const std::string state = text_at(link, "state");
    const std::string since = human_duration(number_or_zero(link, "since_s"));
    const std::string refusal = text_at(link, "refusal");
    const std::string name = name_of(link);
    // Those that call us may have been switched off.
    const Level level = text_at(link, "connects") == "true" ? Level::kFailure : Level::kWarning;
    if (state == "down")
      return add("links.down", Level::kWarning,
                 fmt::format("the link to {} was taken down by hand {} ago", name, since),
                 fmt::format("`timsctl link up {}`", printable(text_at(link, "via"))));
    if (!refusal.empty())
      return add("links.refused", level,
                 fmt::format("the link to {} is refused: {}", name, printable(refusal)));
    if (state == "idle")
      return add("links.down", level,
                 fmt::format("the link to {} has no address to call: its name is not known", name),
                 "the name in `to` of its [[link]], or the name service: `getent hosts NAME`");
    add("links.down", level,
        fmt::format("the link to {} is not up: nothing is heard for {}", name, since));
  }

  void working(const json::object& link) {
    const std::string name = name_of(link);
    if (number_or_zero(link, "mtu_bytes") <= kMtuBase &&
        number_or_zero(link, "since_s") > kMtuFoundAfter_s)
      add("links.mtu", Level::kWarning,
          fmt::format("the link to {} carries no datagrams above {:.0f} bytes", name, kMtuBase));
    const double in = number_or_zero(link, "loss_in");
    const double out = number_or_zero(link, "loss_out");
    if (std::max(in, out) > kLossMax)
      add("links.loss", Level::kWarning,
          fmt::format("the link to {} loses {:.0f}% in and {:.0f}% out", name, in * 100,
                      out * 100));
    const double offset = number_or_zero(link, "clock.offset_s");
    if (std::abs(offset) > kClockOffsetMax_s + number_or_zero(link, "clock.uncertainty_s"))
      add("links.clock", Level::kWarning,
          fmt::format("the clock of {} is {} {} this router's", name,
                      human_duration(std::abs(offset)), offset > 0 ? "ahead of" : "behind"));
  }

  void event(const char* kind, const char* id, const char* text) {
    const double count = number_or_zero(facts_.stats, fmt::format("events.{}", kind));
    if (count > 0)
      add(id, Level::kFailure,
          fmt::format("{} ({} time{})", text, human_count(count), count == 1 ? "" : "s"));
  }

  const Facts& facts_;
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> judge_links(const Facts& facts) { return LinkDoctor(facts).examine(); }

}  // namespace timsctl

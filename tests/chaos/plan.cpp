#include "tests/chaos/plan.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

#include "router/core/random.h"

namespace tims::chaos {
namespace {

using namespace std::chrono_literals;

// The command as `timsctl sim show` prints it; the space distinguishes client 1 from client 12.
std::string client_name(std::size_t number) { return fmt::format("client {} ", number); }

std::string components(const Shape& shape, std::size_t host, const std::string& client) {
  std::string text;
  for (std::size_t i = 0; i < kClientsPerHost && host < shape.hosts.size(); ++i)
    text += fmt::format("{}\"{}\"", i == 0 ? "" : ", ",
                        fmt::format(fmt::runtime(client), host * kClientsPerHost + i));
  return "[" + text + "]";
}

class Planner {
 public:
  Planner(std::uint64_t seed, std::size_t number, const Shape& shape)
      : shape_(shape),
        number_(number),
        random_(core::spread(seed) + number * 0x9E3779B97F4A7C15U) {}

  Round make(Duration span_max) {
    Round round;
    round.span = span_max / 2 + within(span_max / 2);
    round.kills = number_ % 2 == 0;
    for (Duration at = within(500ms); at < round.span; at += 50ms + within(1500ms)) {
      if (round.kills && one_in(2))
        lose_power(at, round.steps);
      else
        spoil_line(at, round.steps);
    }
    std::ranges::stable_sort(round.steps, {}, &Step::at);
    std::erase_if(round.steps, [&](const Step& step) { return step.at > round.span; });
    return round;
  }

 private:
  std::size_t below(std::size_t limit) { return core::next_random(random_) % limit; }
  bool one_in(std::size_t n) { return below(n) == 0; }
  Duration within(Duration span) {
    return Duration(static_cast<std::int64_t>(below(static_cast<std::size_t>(span.count()))));
  }

  void lose_power(Duration at, std::vector<Step>& steps) {
    const std::size_t host = below(shape_.hosts.size());
    const std::string& name = shape_.hosts[host].name;
    std::vector<std::string> kill{"kill", name};
    const std::size_t kind = below(3);
    if (kind == 1) kill.emplace_back("router");
    if (kind == 2) kill.push_back(client_name(host * kClientsPerHost + below(kClientsPerHost)));
    steps.push_back({at, std::move(kill)});
    const Duration away = one_in(2) ? within(100ms) : within(3s);
    steps.push_back({at + away, {"start", name}});
  }

  void spoil_line(Duration at, std::vector<Step>& steps) {
    const Host& host = shape_.hosts[1 + below(shape_.hosts.size() - 1)];
    std::vector<std::string> arguments{"fault", host.line};
    for (std::string& argument : how()) arguments.push_back(std::move(argument));
    steps.push_back({at, std::move(arguments)});
    const Duration length = 50ms + (one_in(2) ? within(1s) : within(5s));
    steps.push_back({at + length, {"fault", host.line, "heal"}});
  }

  std::vector<std::string> how() {
    constexpr std::array<std::string_view, 5> kProfiles{"wifi", "corridor", "lte", "blackout",
                                                        "cable"};
    if (one_in(4)) return {"cut"};
    if (one_in(3))
      return {fmt::format("loss={}%", below(30)), fmt::format("delay={}ms", below(50)),
              fmt::format("jitter={}ms", below(20)), fmt::format("duplicate={}%", below(10)),
              fmt::format("reorder={}%", below(10))};
    std::vector<std::string> arguments{std::string(kProfiles[below(kProfiles.size())])};
    if (one_in(3)) arguments.emplace_back(one_in(2) ? "direction=up" : "direction=down");
    return arguments;
  }

  const Shape& shape_;
  const std::size_t number_;
  std::uint64_t random_;
};

}  // namespace

Address Shape::client_address(std::size_t client) const {
  const Host& host = hosts[client / kClientsPerHost];
  return Address::of({.system = host.router.fields().system,
                      .class_id = class_id::kTest,
                      .instance = static_cast<std::uint32_t>(client)});
}

std::optional<std::size_t> Shape::next_down(std::size_t host, std::size_t below) const {
  if (host == below) return host;
  for (std::size_t at = below; hosts[at].above; at = *hosts[at].above)
    if (hosts[at].above == host) return at;
  return std::nullopt;
}

Shape make_shape(std::size_t robots) {
  Shape shape;
  shape.hosts.push_back({.name = "base", .router = Address::of({.instance = 1})});
  for (std::size_t n = 1; n <= robots; ++n) {
    const auto system = static_cast<std::uint32_t>(n);
    const std::size_t main = shape.hosts.size();
    shape.hosts.push_back({.name = fmt::format("robot{}-main", n),
                           .above = 0,
                           .router = Address::of({.system = system, .instance = 1}),
                           .line = fmt::format("robot{}-base", n)});
    shape.hosts.push_back({.name = fmt::format("robot{}-arm", n),
                           .above = main,
                           .router = Address::of({.system = system, .instance = 2}),
                           .line = fmt::format("robot{}-arm", n)});
  }
  return shape;
}

std::string fleet_file(const Shape& shape, const std::string& client) {
  std::string text = fmt::format("[base]\ncomponents = {}\n", components(shape, 0, client));
  for (std::size_t main = 1; main < shape.hosts.size(); main += 2)
    text += fmt::format(
        "[[robot]]\nhosts = [\"main\", \"arm\"]\nlink = \"cable\"\n"
        "components.main = {}\ncomponents.arm = {}\n",
        components(shape, main, client), components(shape, main + 1, client));
  return text;
}

Round plan_round(std::uint64_t seed, std::size_t number, const Shape& shape, Duration span_max) {
  return Planner(seed, number, shape).make(span_max);
}

std::vector<Step> healing(const Shape& shape) {
  std::vector<Step> steps;
  for (const Host& host : shape.hosts) {
    if (host.above) steps.push_back({{}, {"fault", host.line, "heal"}});
    steps.push_back({{}, {"start", host.name}});
  }
  return steps;
}

}  // namespace tims::chaos

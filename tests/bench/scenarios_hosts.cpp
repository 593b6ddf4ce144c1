// Scenarios between two hosts.
#include "router/io/dds/dds_engine.h"
#include "tests/bench/cases.h"

namespace tims::bench {
namespace {

constexpr double kHostsRoundTripRatio = 1.15;
constexpr double kHostsRate = 2 * kMillion;
constexpr double kHostsMb = 1024 * 1.048576;  // 1 GiB
constexpr std::uint64_t kMbit = 1'000'000;
constexpr Cable kShaped{.rate_bits = 50 * kMbit};
constexpr Cable kLossy{
    .loss = 0.1, .delay = std::chrono::milliseconds(10), .rate_bits = 50 * kMbit};
constexpr double kUrgentMoreUs = 400;
constexpr double kUrgentUs = 5000;
constexpr std::uint32_t kCommandPriority = 40;  // of a pilot
constexpr std::uint32_t kCameraPriority = 20;
constexpr double kLossyUs = 80'000;
constexpr double kLossyMb = 0.7 * 50 / 8;
constexpr double kIdleBytes = 500;
constexpr double kSealedRoundTripRatio = 1.1;
constexpr double kSealedRateRatio = 1 / 0.6;
constexpr double kSealedIdleBytes = 80;  // in addition
constexpr std::uint64_t kFloodPerSecond = 100'000;
constexpr double kFloodMoreUs = 1000;
constexpr double kFloodMoreMb = 1;
constexpr double kDeathSeconds = 3 * 0.3 + 0.1;
constexpr double kDdsRoundTripRatio = 1.5;
constexpr double kJoinSeconds = 3;
constexpr double kFleetStartSeconds = 10;
constexpr double kFleetMb = 40 * 1.048576;
constexpr double kFailoverSeconds = 3 * 0.3;

// The limit is a chain of the same length: two bare relays.
Case hosts_rtt(std::size_t payload, bool one_cpu) {
  Case c{.scenario = one_cpu ? "hosts_rtt@1cpu" : "hosts_rtt", .payload = payload};
  c.contenders = {{"tims", round_trip("tims", Between::kTwoRouters, payload, one_cpu)},
                  {"limit", round_trip("udp", Between::kTwoRelays, payload, one_cpu)}};
  c.rows = {{"tims", "p50_us", "limit", {}}};
  if (payload == 64) c.rows[0].target = {.ratio_max = kHostsRoundTripRatio};
  return c;
}

// A sealed link beside an open one.
Case sealed_rtt(std::size_t payload, bool one_cpu) {
  const Experiment open = round_trip("tims", Between::kTwoRouters, payload, one_cpu);
  Experiment sealed = open;
  sealed.sealed = true;
  Case c{.scenario = one_cpu ? "sealed_rtt@1cpu" : "sealed_rtt", .payload = payload};
  c.contenders = {{"tims-sealed", sealed}, {"tims", open}};
  c.rows = {{"tims-sealed", "p50_us", "tims", {}}};
  if (payload == 64) c.rows[0].target = {.ratio_max = kSealedRoundTripRatio};
  return c;
}

Case sealed_throughput(std::size_t payload) {
  const Experiment open = stream("tims", Between::kTwoRouters, payload);
  Experiment sealed = open;
  sealed.sealed = true;
  Case c{.scenario = "sealed_throughput", .payload = payload};
  const char* const rate = rate_metric(payload);
  c.contenders = {{"tims-sealed", sealed},
                  {"tims", open},
                  {"limit-sealed", stream("udp-sealed", Between::kTwoRelays, payload)},
                  {"limit-chain", stream("udp", Between::kTwoRelays, payload)}};
  c.rows = {{"tims-sealed", rate, "tims", {}},
            {"tims-sealed", "cpu_s", "tims", {}},
            {"tims-sealed", rate, "limit-sealed", {}},
            {"limit-sealed", rate, "limit-chain", {}}};
  if (payload == 64 || payload == kMi) c.rows[0].target = {.ratio_max = kSealedRateRatio};
  return c;
}

Case sealed_idle() {
  const Experiment open{.shape = Shape::kIdleLink, .between = Between::kTwoRouters};
  Experiment sealed = open;
  sealed.sealed = true;
  return {.scenario = "sealed_idle",
          .payload = 0,
          .contenders = {{"tims-sealed", sealed}, {"tims", open}},
          .rows = {{"tims-sealed", "up_bytes_per_s", "tims", {.above_max = kSealedIdleBytes}},
                   {"tims-sealed", "down_bytes_per_s", "tims", {.above_max = kSealedIdleBytes}}}};
}

void add_sealed_cases(std::vector<Case>& cases, bool quick) {
  for (const bool one_cpu : {false, true})
    for (const std::size_t payload : sizes(quick).hosts_round_trip)
      cases.push_back(sealed_rtt(payload, one_cpu));
  for (const std::size_t payload : sizes(quick).stream) cases.push_back(sealed_throughput(payload));
  cases.push_back(sealed_idle());
}

// Links over TCP beside those over UDP; the limit is what else could carry them where no UDP
// passes.
Case tcp_hosts_rtt(std::size_t payload, bool one_cpu) {
  Experiment by_tcp = round_trip("tims", Between::kTwoRouters, payload, one_cpu);
  Experiment by_udp = by_tcp;
  by_tcp.paths = "tcp";
  by_udp.paths = "udp";
  Case c{.scenario = one_cpu ? "tcp_hosts_rtt@1cpu" : "tcp_hosts_rtt", .payload = payload};
  c.contenders = {{"tims", by_tcp}, {"tims-udp", by_udp}};
  c.rows = {{"tims", "p50_us", "tims-udp", {}}};
  if (!io::DdsEngine::built_in()) return c;
  c.contenders.emplace_back("limit", round_trip("dds-tcp", Between::kCable, payload, one_cpu));
  c.contenders.emplace_back("limit-udp", round_trip("dds", Between::kCable, payload, one_cpu));
  c.rows.push_back({"tims", "p50_us", "limit", {}});
  c.rows.push_back({"limit", "p50_us", "limit-udp", {}});
  return c;
}

Case tcp_hosts_throughput(std::size_t payload) {
  Experiment by_tcp = stream("tims", Between::kTwoRouters, payload);
  Experiment by_udp = by_tcp;
  by_tcp.paths = "tcp";
  by_udp.paths = "udp";
  return {
      .scenario = "tcp_hosts_throughput",
      .payload = payload,
      .contenders = {{"tims", by_tcp}, {"tims-udp", by_udp}},
      .rows = {{"tims", rate_metric(payload), "tims-udp", {}}, {"tims", "cpu_s", "tims-udp", {}}}};
}

void add_tcp_cases(std::vector<Case>& cases, bool quick) {
  for (const bool one_cpu : {false, true})
    for (const std::size_t payload : sizes(quick).hosts_round_trip)
      cases.push_back(tcp_hosts_rtt(payload, one_cpu));
  for (const std::size_t payload : sizes(quick).stream)
    cases.push_back(tcp_hosts_throughput(payload));
}

// Over DDS without routers: the cost of the engine in addition to the library it uses.
Case dds_rtt(std::size_t payload, bool one_cpu) {
  return {
      .scenario = one_cpu ? "dds_rtt@1cpu" : "dds_rtt",
      .payload = payload,
      .contenders = {{"tims-engine", round_trip("dds-engine", Between::kCable, payload, one_cpu)},
                     {"limit", round_trip("dds", Between::kCable, payload, one_cpu)}},
      .rows = {{"tims-engine", "p50_us", "limit", {.ratio_max = kDdsRoundTripRatio}}}};
}

Case dds_throughput(std::size_t payload) {
  return {.scenario = "dds_throughput",
          .payload = payload,
          .contenders = {{"tims-engine", stream("dds-engine", Between::kCable, payload)}},
          .rows = {{"tims-engine", rate_metric(payload), "", {}}}};
}

// The limit has no routers, and answers in the library's thread.
Case dds_hosts_rtt(std::size_t payload, bool one_cpu) {
  Experiment ours = round_trip("tims", Between::kTwoRouters, payload, one_cpu);
  ours.paths = "dds";
  return {.scenario = one_cpu ? "dds_hosts_rtt@1cpu" : "dds_hosts_rtt",
          .payload = payload,
          .contenders = {{"tims", ours},
                         {"limit", round_trip("dds", Between::kCable, payload, one_cpu)}},
          .rows = {{"tims", "p50_us", "limit", {.ratio_max = kDdsRoundTripRatio}}}};
}

Case fleet_join() {
  Experiment plain{.shape = Shape::kFleetJoin, .between = Between::kTwoRouters};
  Experiment by_name = plain;
  by_name.paths = "udp+dds";
  return {.scenario = "fleet_join",
          .payload = 0,
          .contenders = {{"tims", by_name}, {"tims-plain", plain}},
          .rows = {{"tims", "join_s", "tims-plain", {.at_most = kJoinSeconds}},
                   {"tims", "rss_mb", "tims-plain", {.above_max = kFleetMb}},
                   {"tims", "cpu_ms_in_5s", "tims-plain", {}},
                   {"tims", "up_bytes_per_s", "", {}},
                   {"tims", "down_bytes_per_s", "", {}}}};
}

// On one host.
Case fleet_start(std::uint64_t robots) {
  return {.scenario = "fleet_start@" + std::to_string(robots),
          .payload = 0,
          .contenders = {{"tims", {.shape = Shape::kFleetStart, .count = robots}}},
          .rows = {{"tims", "join_s", "", {.at_most = kFleetStartSeconds}},
                   {"tims", "join_again_s", "", {.at_most = kFleetStartSeconds}},
                   {"tims", "cpu_ms_in_5s", "", {}},
                   {"tims", "base_cpu_ms_in_5s", "", {}},
                   {"tims", "rss_mb", "", {}},
                   {"tims", "base_rss_mb", "", {}}}};
}

Case failover() {
  return {.scenario = "failover",
          .payload = 8,
          .contenders =
              {{"tims",
                {.shape = Shape::kFailover, .between = Between::kTwoRouters, .paths = "udp+dds"}}},
          .rows = {{"tims", "failover_s", "", {.at_most = kFailoverSeconds}},
                   {"tims", "return_s", "", {}},
                   {"tims", "return_delay_s", "", {}},
                   {"tims", "lost", "", {.at_most = 0}}}};
}

void add_dds_cases(std::vector<Case>& cases, bool quick) {
  for (const bool one_cpu : {false, true})
    for (const std::size_t payload : sizes(quick).round_trip)
      cases.push_back(dds_rtt(payload, one_cpu));
  for (const std::size_t payload : sizes(quick).stream) cases.push_back(dds_throughput(payload));
  for (const bool one_cpu : {false, true})
    for (const std::size_t payload : sizes(quick).round_trip)
      cases.push_back(dds_hosts_rtt(payload, one_cpu));
  cases.push_back(fleet_join());
  for (const std::uint64_t robots : {10U, 50U, 200U}) cases.push_back(fleet_start(robots));
  cases.push_back(failover());
}

Case hosts_throughput(std::size_t payload) {
  const char* metric = rate_metric(payload);
  Case c{.scenario = "hosts_throughput", .payload = payload};
  c.contenders = {{"tims", stream("tims", Between::kTwoRouters, payload)},
                  {"limit", stream("udp", Between::kCable, payload)},
                  {"limit-chain", stream("udp", Between::kTwoRelays, payload)}};
  c.rows = {{"tims", metric, "limit", {}}, {"tims", metric, "limit-chain", {}}};
  if (payload == 64) c.rows[0].target = {.at_least = kHostsRate};
  if (payload == kMi) c.rows[0].target = {.at_least = kHostsMb};
  return c;
}

// Priorities as on a robot: a command together with camera data.
Experiment as_on_a_robot(Experiment pulse) {
  pulse.priority = kCommandPriority;
  pulse.bulk_priority = kCameraPriority;
  return pulse;
}

// A small message of the highest class together with large ones of the lowest; then of adjacent
// classes.
Case urgent_latency() {
  Experiment with_rate = pulse("tims", Between::kTwoRouters, kShaped, kMi);
  with_rate.rate_is_set = true;
  Case c{.scenario = "urgent_latency", .payload = 64};
  c.contenders = {{"tims", pulse("tims", Between::kTwoRouters, kShaped, kMi)},
                  {"tims-rate", with_rate},
                  {"tims-40", as_on_a_robot(pulse("tims", Between::kTwoRouters, kShaped, kMi))},
                  {"tims-40-rate", as_on_a_robot(with_rate)},
                  {"tims-unloaded", pulse("tims", Between::kTwoRouters, kShaped)},
                  {"limit", pulse("udp", Between::kTwoRelays, kShaped)}};
  c.rows = {{"tims-unloaded", "p99_us", "limit", {}},
            {"tims-rate", "p50_us", "tims-unloaded", {}},
            {"tims", "p50_us", "tims-unloaded", {}},
            {"tims-rate", "p99_us", "tims-unloaded", {.above_max = kUrgentMoreUs}},
            {"tims-40-rate", "p99_us", "tims-unloaded", {.above_max = kUrgentMoreUs}},
            {"tims", "p99_us", "tims-unloaded", {.at_most = kUrgentUs}},
            {"tims-40", "p50_us", "tims-unloaded", {}},
            {"tims-40", "p99_us", "tims-unloaded", {.at_most = kUrgentUs}},
            {"tims-rate", "mb_per_s", "", {}},
            {"tims", "mb_per_s", "", {}},
            {"tims-40", "mb_per_s", "", {}}};
  return c;
}

Case lossy_link() {
  return {.scenario = "lossy_link",
          .payload = 64,
          .contenders = {{"tims", pulse("tims", Between::kTwoRouters, kLossy, 64 * kKi)}},
          .rows = {{"tims", "p99_us", "", {.at_most = kLossyUs}},
                   {"tims", "mb_per_s", "", {.at_least = kLossyMb}}}};
}

// A link that is up while somebody floods one of its routers.
Case hello_flood() {
  const auto link = [](bool sealed, std::uint64_t flood) {
    Experiment one = pulse("tims", Between::kTwoRouters, {});
    one.sealed = sealed;
    one.flood = flood;
    return one;
  };
  Case c{.scenario = "hello_flood",
         .payload = 64,
         .contenders = {{"tims", link(false, kFloodPerSecond)},
                        {"tims-quiet", link(false, 0)},
                        {"tims-sealed", link(true, kFloodPerSecond)},
                        {"tims-sealed-quiet", link(true, 0)}}};
  for (const std::string peer : {"tims", "tims-sealed"}) {
    const std::string quiet = peer + "-quiet";
    c.rows.push_back({peer, "flood_per_s", "", {}});
    c.rows.push_back({peer, "p50_us", quiet, {}});
    c.rows.push_back({peer, "p99_us", quiet, {.above_max = kFloodMoreUs}});
    c.rows.push_back({peer, "base_rss_mb", quiet, {.above_max = kFloodMoreMb}});
  }
  return c;
}

Case link_case(const char* scenario, Shape shape, const std::vector<Row>& rows) {
  return {.scenario = scenario,
          .payload = 0,
          .contenders = {{"tims", {.shape = shape, .between = Between::kTwoRouters}}},
          .rows = rows};
}

}  // namespace

// Scenarios between network namespaces.
std::vector<Case> hosts_cases(bool quick) {
  std::vector<Case> cases;
  for (const bool one_cpu : {false, true})
    for (const std::size_t payload : sizes(quick).hosts_round_trip)
      cases.push_back(hosts_rtt(payload, one_cpu));
  for (const std::size_t payload : sizes(quick).stream) cases.push_back(hosts_throughput(payload));
  add_sealed_cases(cases, quick);
  add_tcp_cases(cases, quick);
  if (io::DdsEngine::built_in()) add_dds_cases(cases, quick);
  cases.push_back(urgent_latency());
  cases.push_back(lossy_link());
  cases.push_back(hello_flood());
  cases.push_back(link_case("link_idle", Shape::kIdleLink,
                            {{"tims", "up_bytes_per_s", "", {.at_most = kIdleBytes}},
                             {"tims", "down_bytes_per_s", "", {.at_most = kIdleBytes}}}));
  cases.push_back(link_case("link_death", Shape::kLinkDeath,
                            {{"tims", "death_s", "", {.at_most = kDeathSeconds}}}));
  return cases;
}

}  // namespace tims::bench

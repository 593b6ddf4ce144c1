#include "tests/bench/compression.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "os/clock.h"
#include "rack/proxies/ladar.h"
#include "tests/bench/metrics.h"
#include "tests/sim/simulated_network.h"

namespace tims::bench {
namespace {

using namespace std::chrono_literals;
using Body = std::vector<std::byte>;

constexpr std::uint64_t kBytesPerSecond = 1'250'000;  // 10 Mbit/s
constexpr Address kSink{0x00020000};
constexpr Address kLadar{0x01140000};
constexpr std::size_t kScansMax = 500;

std::string log_of(const std::string& drive) {
  const char* const folder = std::getenv("RACK_TEST_DATA");
  return folder == nullptr ? "" : std::string(folder) + "/" + drive + ".clf";
}

// The body of LadarData with these distances, in millimetres.
Body ladar_body(const std::vector<int>& distances, double step, std::uint32_t time) {
  rack::LadarData scan{.recordingTime = time, .maxRange = 80'000};
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const bool hit = distances[i] > 20;
    scan.points.push_back({.angle = static_cast<float>(static_cast<double>(i) * step),
                           .distance = distances[i],
                           .type = hit ? 0 : rack::ladar_point::kInvalid});
  }
  Body body(rack::encoded_size(scan));
  return rack::encode(scan, body) ? body : Body();
}

// Columns 24 to 706 of a line: distances in mm.
std::vector<Body> hokuyo_scans() {
  std::ifstream file(TIMS_BENCH_HOKUYO);
  std::vector<Body> scans;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::vector<int> all{std::istream_iterator<double>(words), {}};
    if (all.size() < 700) continue;
    all.erase(all.begin(), all.begin() + 24);
    scans.push_back(ladar_body(all, 0.0061, static_cast<std::uint32_t>(scans.size() * 100)));
  }
  return scans;
}

// FLASER and ROBOTLASER1 of a CARMEN log.
std::vector<Body> carmen_scans(const std::string& path) {
  std::ifstream file(path);
  std::vector<Body> scans;
  for (std::string line; scans.size() < kScansMax && std::getline(file, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    double skipped = 0;
    if (kind == "ROBOTLASER1")
      for (int i = 0; i < 7; ++i) words >> skipped;
    else if (kind != "FLASER")
      continue;
    std::size_t count = 0;
    words >> count;
    std::vector<int> distances(std::min<std::size_t>(count, 2160));
    for (int& distance : distances) {
      double metres = 0;
      words >> metres;
      distance = static_cast<int>(std::lround(metres * 1000));
    }
    const double step = std::numbers::pi / static_cast<double>(std::max<std::size_t>(count, 1));
    scans.push_back(ladar_body(distances, step, static_cast<std::uint32_t>(scans.size() * 100)));
  }
  return scans;
}

std::vector<Body> scans_of(const std::string& drive) {
  return drive == "hokuyo" ? hokuyo_scans() : carmen_scans(log_of(drive));
}

// A robot sends scans to its base as fast as the line takes them.
double scans_per_s(const std::vector<Body>& scans, core::Compression how) {
  constexpr Duration kSettle = 3s;
  constexpr Duration kSpan = 5s;
  tims::sim::SimulatedNetwork network(1);
  auto up = tims::sim::super_link(tims::sim::address_of(0));
  up.packing.compress = how;
  tims::sim::Node& base =
      network.add({.name = "base", .role = core::Role::kTop, .links = {tims::sim::sub_link()}});
  tims::sim::Node& robot = network.add({.name = "robot", .system = 1, .links = {up}});
  network.set_faults({.delay = 1ms, .rate = kBytesPerSecond});
  base.start(network.now());
  robot.start(network.now());
  const auto sink = base.add_client(network.now(), "sink");
  base.add_mailbox(network.now(), sink, kSink);
  const auto source = robot.add_client(network.now(), "source");
  robot.add_mailbox(network.now(), source, kLadar);
  std::uint64_t arrived = 0;
  base.on_arrival = [&](tims::sim::Node&, core::ClientId, tims::sim::Arrival&&) { ++arrived; };
  network.run_for(1s);
  const Header header{.type = type::kData, .priority = 30, .dest = kSink, .src = kLadar};
  std::size_t next = 0;
  std::uint64_t before = 0;
  const Time begin = network.now();
  while (network.now() < begin + kSettle + kSpan) {
    while (robot.links().uplink()->session().queued_bytes() < 200'000)
      robot.send(network.now(), source, header, scans[next++ % scans.size()]);
    network.run_for(5ms);
    if (network.now() < begin + kSettle) before = arrived;
  }
  return static_cast<double>(arrived - before) / std::chrono::duration<double>(kSpan).count();
}

// Mean computing time of compressing and of decompressing one scan, whichever is longer.
double added_us(const std::vector<Body>& scans) {
  link::Packing packing({}, {}, os::now);
  link::PackingCounters sending;
  link::PackingCounters receiving;
  for (const Body& body : scans) {
    std::vector<std::byte> bytes(kHeaderSize + body.size());
    std::ranges::copy(body, bytes.begin() + kHeaderSize);
    const core::Message message{.header = {.type = type::kData, .src = kLadar}, .bytes = bytes};
    auto packed = packing.pack(message, compression::Method::kZstd, {}, sending);
    std::vector<std::byte> back(bytes.size());
    if (packed && !packing.unpack(*packed, back, receiving)) return 1e9;
  }
  const Duration longer = std::max(sending.spent, receiving.spent);
  return std::chrono::duration<double, std::micro>(longer).count() /
         static_cast<double>(scans.size());
}

bool measure(const Plan& plan, core::Compression how) {
  const std::vector<Body> scans = scans_of(plan.link);
  if (scans.empty()) {
    std::fprintf(stderr, "no scans of the drive %s\n", plan.link.c_str());
    return false;
  }
  print_metric("scans_per_s", scans_per_s(scans, how));
  if (how != core::Compression::kOff) print_metric("added_us", added_us(scans));
  return true;
}

}  // namespace

bool measure_compressed_scans(const Plan& plan) { return measure(plan, core::Compression::kAuto); }
bool measure_plain_scans(const Plan& plan) { return measure(plan, core::Compression::kOff); }

std::vector<std::string> recorded_drives() {
  std::vector<std::string> drives{"hokuyo"};
  for (const char* const drive : {"fr079", "intel", "aces"})
    if (std::filesystem::exists(log_of(drive))) drives.emplace_back(drive);
  return drives;
}

}  // namespace tims::bench

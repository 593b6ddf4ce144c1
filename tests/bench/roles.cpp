#include "tests/bench/roles.h"

#include <csignal>
#include <cstdio>

#include <sys/prctl.h>

#include "tests/bench/camera_cost.h"
#include "tests/bench/components.h"
#include "tests/bench/compression.h"
#include "tests/bench/cyclictest.h"
#include "tests/bench/dds_engine_link.h"
#include "tests/bench/dds_limit.h"
#include "tests/bench/decoders.h"
#include "tests/bench/device_latency.h"
#include "tests/bench/fleet.h"
#include "tests/bench/hello_flood.h"
#include "tests/bench/limits.h"
#include "tests/bench/policy_bench.h"
#include "tests/bench/pulse.h"
#include "tests/bench/register_bench.h"
#include "tests/bench/relay.h"
#include "tests/bench/ring_link.h"
#include "tests/bench/robot_start.h"
#include "tests/bench/round_trip.h"
#include "tests/bench/sealed_burst.h"
#include "tests/bench/sealing.h"
#include "tests/bench/self.h"
#include "tests/bench/stream.h"
#include "tests/bench/table_bench.h"
#include "tests/bench/tcp_link.h"
#include "tests/bench/tims_link.h"
#include "tests/bench/udp_link.h"

namespace tims::bench {
namespace {

void print_ready() {
  std::puts("ready");
  std::fflush(stdout);
}

template <typename L>
bool play(const Plan& plan, Result<L> link) {
  if (!link) {
    std::fprintf(stderr, "%s: %s\n", plan.link.c_str(), link.error().message().c_str());
    return false;
  }
  print_ready();
  if (plan.role == "ping") return Ping<L>(plan, *link).run();
  if (plan.role == "echo") return Echo<L>(plan, *link).run();
  if (plan.role == "source") return Source<L>(plan, *link).run();
  if (plan.role == "sink") return Sink<L>(plan, *link).run();
  if (plan.role == "pulse") return Pulse<L>(plan, *link).run();
  if (plan.role == "gauge") return Gauge<L>(plan, *link).run();
  std::fprintf(stderr, "unknown role \"%s\"\n", plan.role.c_str());
  return false;
}

struct Alone {
  const char* role;
  const char* link;  // empty: any
  bool (*run)(const Plan&);
};
constexpr Alone kAlone[] = {
    {"ping", "futex", futex_ping},
    {"echo", "futex", futex_echo},
    {"ping", "dds", dds_ping},
    {"echo", "dds", dds_echo},
    {"ping", "dds-tcp", dds_ping},
    {"echo", "dds-tcp", dds_echo},
    {"memcpy", "memcpy", copy_through_memory},
    {"memcpy-slots", "memcpy-slots", copy_into_slots},
    {"self", "self", send_to_myself},
    {"self-loan", "self-loan", loan_to_myself},
    {"register-tcp", "register-tcp", register_over_tcp},
    {"register-unix", "register-unix", register_over_unix},
    {"fleet", "fleet", play_fleet},
    {"scanner", "scan", play_scanner},
    {"listener", "scan", play_listener},
    {"clockwork", "clockwork", play_clockwork},
    {"cyclictest", "cyclictest", run_cyclictest},
    {"burn", "burn", burn},
    {"robot", "robot", start_robot},
    {"camera", "camera", measure_camera},
    {"bare-pictures", "bare-pictures", measure_bare_pictures},
    {"lookup", "lookup", measure_lookup},
    {"bare-reads", "bare-reads", measure_bare_reads},
    {"verdicts", "verdicts", measure_verdicts},
    {"table-memory", "table-memory", measure_table_memory},
    {"compressed", "", measure_compressed_scans},
    {"uncompressed", "", measure_plain_scans},
    {"flood", "", send_hello_flood},
    {"seal", "seal", seal_datagrams},
    {"encrypt", "encrypt", encrypt_alone},
    {"decode", "", measure_decoder},
    {"copy", "", measure_copy_of_pieces},
    {"device", "", play_device},
    {"driver", "", listen_to_driver},
    {"bare-reader", "", read_bare},
};

}  // namespace

bool run_role(const Plan& plan) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // also with strace, which would not kill it
  if (plan.role == "relay") return run_relay();
  if (plan.role == "udp-relay")
    return run_udp_relay(plan.host, plan.endpoint, plan.link == "udp-sealed");
  for (const Alone& alone : kAlone) {
    const bool is_any = *alone.link == '\0';
    if (plan.role != alone.role || (!is_any && plan.link != alone.link)) continue;
    print_ready();
    return alone.run(plan);
  }
  using enum RingLink::Copy;
  using enum TimsLink::Method;
  using enum TcpLink::Between;
  if (plan.link == "ring") return play(plan, RingLink::open(plan, kWhole));
  if (plan.link == "ring-head") return play(plan, RingLink::open(plan, kHeadOnly));
  if (plan.link == "tims") return play(plan, TimsLink::open(plan, kCopy));
  if (plan.link == "tims-loan") return play(plan, TimsLink::open(plan, kLoan));
  if (plan.link == "tcp-router") return play(plan, TcpLink::open(plan, kRouter));
  if (plan.link == "tcp-relay") return play(plan, TcpLink::open(plan, kRelay));
  if (plan.link == "dds-engine") return play(plan, DdsEngineLink::open(plan));
  if (plan.link == "udp") return play(plan, UdpLink::open(plan, kUdpDatagram));
  if (plan.link == "udp-sealed")
    return play(plan, UdpLink::open(plan, kUdpDatagram - SealedBurst::kOverhead));
  std::fprintf(stderr, "unknown link \"%s\"\n", plan.link.c_str());
  return false;
}

}  // namespace tims::bench

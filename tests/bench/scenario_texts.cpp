#include "tests/bench/scenarios.h"

namespace tims::bench {

std::vector<ScenarioText> scenario_texts() {
  return {
      {"local_rtt", "round trip between two processes, both sleep while they wait"},
      {"local_rtt@1cpu", "the same, both on one CPU"},
      {"local_throughput", "one producer to one owner, send and loan"},
      {"local_throughput@1thread", "from a thread to itself; limit: memcpy into as many slots"},
      {"local_syscalls", "system calls a million messages of that, counted by strace"},
      {"fanout_throughput", "one publisher, eight subscribers"},
      {"router_rtt", "round trip through the TCP port; limit: a bare epoll relay"},
      {"router_rtt@1cpu", "the same, all three processes on one CPU"},
      {"router_throughput", "one pair through the TCP port"},
      {"router_throughput@8pairs", "eight pairs at once, the sum"},
      {"hosts_rtt", "round trip between two hosts, a router on each; limit: bare relays, UDP"},
      {"hosts_rtt@1cpu", "the same, all four processes on one CPU"},
      {"hosts_throughput", "from host to host; limit: a bare UDP sender, and a chain of relays"},
      {"dds_rtt", "round trip between two hosts by DDS, no routers; limit: bare Fast DDS"},
      {"dds_throughput", "from host to host by DDS, no routers"},
      {"urgent_latency", "64 B while 1 MiB messages fill 50 Mbit/s, one way; rate told or found"},
      {"lossy_link", "10 % loss, 20 ms, 50 Mbit/s: 64 KiB messages, and 64 B urgently"},
      {"link_idle", "bytes a second over a link that nobody uses, headers included"},
      {"link_death", "seconds from the cut of a cable until the other end has withdrawn"},
      {"convergence", "a router above 1000 with 100 mailboxes each is killed and comes back"},
      {"component_latency", "from put of a DataModule to its listener, one way; beside bare send"},
      {"component_latency@1cpu", "the same, both on one CPU"},
      {"component_cpu", "of a DataModule: 361 points at 75 Hz to eight listeners"},
      {"component_jitter", "lateness of a 1 kHz DataModule under load; beside cyclictest"},
      {"robot_start", "from `timsctl up` until all of twelve components are on"},
      {"register_tcp",
       "1000 clients with 100 mailboxes each, TCP: seconds until all are confirmed"},
      {"register_unix", "the same through libtims"},
      {"lookup", "ns a look-up in a table of 10 to 1 000 000 mailboxes; limit: one read of memory"},
      {"table_memory", "bytes a mailbox in the router's table, at the worst moment"},
      {"idle", "CPU, wake-ups and memory of a router nobody uses"},
  };
}

}  // namespace tims::bench

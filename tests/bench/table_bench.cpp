#include "tests/bench/table_bench.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <random>
#include <vector>

#include <malloc.h>

#include "os/clock.h"
#include "router/core/registrations.h"
#include "tests/bench/metrics.h"

namespace tims::bench {
namespace {

constexpr core::HashSeed kSeed{.first = 0x5DEECE66D, .second = 0xB5026F5AA96619E9};

// A realistic fleet: several mailboxes per component, some hundred systems.
Address nth_address(std::uint64_t n) {
  constexpr std::uint64_t kLocals = 8;
  const std::uint64_t component = n / kLocals;
  return Address(static_cast<std::uint32_t>(component << 8 | n % kLocals));
}

// Indices of 0..count-1 in random order, too many for the branch predictor to learn.
std::vector<std::uint32_t> random_order(std::size_t count) {
  constexpr std::size_t kLengthMin = 1 << 16;
  std::mt19937 random(1);
  std::vector<std::uint32_t> order;
  while (order.size() < kLengthMin) {
    std::vector<std::uint32_t> once(count);
    std::iota(once.begin(), once.end(), 0U);
    std::shuffle(once.begin(), once.end(), random);
    order.insert(order.end(), once.begin(), once.end());
  }
  return order;
}

// `look(key)` returns 0 that depends on the result, so that look-ups cannot overlap.
template <typename Look>
void time_looks(const Plan& plan, const std::vector<std::uint32_t>& keys, Look look) {
  std::uint64_t looks = 0;
  std::uint32_t zero = 0;
  const auto all = [&] {
    for (const std::uint32_t key : keys) zero = look(key + zero);
    looks += keys.size();
  };
  all();
  looks = 0;
  const Time start = os::now();
  Time now = start;
  for (; now < start + plan.seconds; now = os::now()) all();
  const double ns = static_cast<double>((now - start).count());
  print_metric("lookup_ns", ns / static_cast<double>(looks) + zero);
}

}  // namespace

bool measure_lookup(const Plan& plan) {
  core::Table table(kSeed);
  for (std::uint64_t i = 0; i < plan.count; ++i)
    table.insert({.address = nth_address(i), .owner = core::ClientId{1}});
  std::vector<std::uint32_t> keys = random_order(plan.count);
  for (std::uint32_t& key : keys) key = nth_address(key).raw();
  time_looks(plan, keys, [&](std::uint32_t key) { return table.find(Address(key))->handle; });
  return true;
}

bool measure_bare_reads(const Plan& plan) {
  // The size of a table with that many mailboxes.
  std::vector<core::Table::Entry> memory(std::bit_ceil(plan.count * 4 / 3 + 1));
  const std::vector<std::uint32_t> keys = random_order(memory.size());
  time_looks(plan, keys, [&](std::uint32_t key) { return memory[key].handle; });
  return true;
}

bool measure_table_memory(const Plan& plan) {
  constexpr std::uint64_t kPerClient = 100;
  constexpr std::uint64_t kEnough = 10'000;  // below, fixed costs would dominate
  const auto allocated = [] {
    const struct mallinfo2 info = ::mallinfo2();
    return info.uordblks + info.hblkhd;
  };
  const std::size_t before = allocated();
  core::Registrations registrations(kSeed, text_sink());
  std::vector<core::Client> clients(plan.count / kPerClient + 1);
  const std::size_t fixed = clients.size() * sizeof(core::Client);
  double worst = 0;
  double at_the_end = 0;
  for (std::uint64_t i = 0; i < plan.count; ++i) {
    registrations.add(Time{}, clients[i / kPerClient], nth_address(i), 0);
    if ((i + 1) % kPerClient != 0 || i < kEnough) continue;
    at_the_end = static_cast<double>(allocated() - before - fixed) / static_cast<double>(i + 1);
    worst = std::max(worst, at_the_end);
  }
  print_metric("bytes_per_mailbox", worst);
  print_metric("bytes_per_mailbox_at_the_end", at_the_end);
  return true;
}

}  // namespace tims::bench

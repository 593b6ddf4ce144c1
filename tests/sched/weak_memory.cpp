#include "tests/sched/weak_memory.h"

#include <algorithm>
#include <cstdlib>

namespace tims::sched {

using std::memory_order;

namespace {

bool acquires(memory_order order) {
  return order != memory_order::relaxed && order != memory_order::release;
}
bool releases(memory_order order) {
  return order == memory_order::release || order == memory_order::acq_rel ||
         order == memory_order::seq_cst;
}

template <typename View>
void join(View& into, const View& other) {
  for (std::size_t i = 0; i < into.size(); ++i) into[i] = std::max(into[i], other[i]);
}

}  // namespace

void WeakMemory::reset(std::uint32_t seed) {
  random_.seed(seed);
  used_ = 0;
  views_ = {};
  raced_ = false;
}

void WeakMemory::learn_everything(int thread) {
  for (std::size_t i = 0; i < used_; ++i)
    view(thread)[i] = static_cast<std::uint16_t>(locations_[i].stores.size() - 1);
}

std::size_t WeakMemory::find(const void* where, std::uint64_t newest) {
  for (std::size_t i = 0; i < used_; ++i)
    if (locations_[i].where == where) return i;
  if (used_ == kLocationsMax) std::abort();
  if (used_ == locations_.size()) locations_.emplace_back();
  Location& location = locations_[used_];
  location.where = where;
  location.stores.assign(1, {newest, {}});
  location.last_sequential = 0;
  location.last_write = 0;
  return used_++;
}

// Chooses one of the stores that the thread may still read.
std::uint16_t WeakMemory::choose(int thread, std::size_t location, memory_order order) {
  const Location& l = locations_[location];
  const auto newest = static_cast<std::uint16_t>(l.stores.size() - 1);
  std::uint16_t oldest = view(thread)[location];
  if (order == memory_order::seq_cst) oldest = std::max(oldest, l.last_sequential);
  if (random_() % 2 == 0) return newest;
  return static_cast<std::uint16_t>(oldest + random_() % (newest - oldest + 1U));
}

void WeakMemory::acquire(int thread, std::size_t location, std::uint16_t store,
                         memory_order order) {
  view(thread)[location] = std::max(view(thread)[location], store);
  if (acquires(order)) join(view(thread), locations_[location].stores[store].released);
}

// `passed_on`: the view released by the store before, if this one continues its release sequence.
void WeakMemory::append(int thread, std::size_t location, std::uint64_t value, memory_order order,
                        const View& passed_on) {
  Location& l = locations_[location];
  const auto number = static_cast<std::uint16_t>(l.stores.size());
  view(thread)[location] = number;
  Store store{value, passed_on};
  if (releases(order)) join(store.released, view(thread));
  store.released[location] = number;
  if (order == memory_order::seq_cst) l.last_sequential = number;
  l.stores.push_back(store);
}

std::uint64_t WeakMemory::load(int thread, const void* where, std::uint64_t newest,
                               memory_order order) {
  const std::size_t location = find(where, newest);
  const std::uint16_t store = choose(thread, location, order);
  acquire(thread, location, store, order);
  return locations_[location].stores[store].value;
}

void WeakMemory::store(int thread, const void* where, std::uint64_t newest, std::uint64_t value,
                       memory_order order) {
  append(thread, find(where, newest), value, order, {});
}

void WeakMemory::update(int thread, const void* where, std::uint64_t newest, std::uint64_t value,
                        memory_order order) {
  const std::size_t location = find(where, newest);
  const auto last = static_cast<std::uint16_t>(locations_[location].stores.size() - 1);
  acquire(thread, location, last, order);
  const View passed_on = locations_[location].stores[last].released;
  append(thread, location, value, order, passed_on);
}

// A failing one is a relaxed load and may have read an old value.
bool WeakMemory::compare_exchange(int thread, const void* where, std::uint64_t newest,
                                  std::uint64_t expected, std::uint64_t desired,
                                  memory_order order) {
  const std::size_t location = find(where, newest);
  const std::uint16_t store = choose(thread, location, memory_order::relaxed);
  if (locations_[location].stores[store].value != expected) {
    acquire(thread, location, store, memory_order::relaxed);
    return false;
  }
  if (newest != expected) {
    acquire(thread, location, static_cast<std::uint16_t>(locations_[location].stores.size() - 1),
            memory_order::relaxed);
    return false;
  }
  update(thread, where, newest, desired, order);
  return true;
}

void WeakMemory::read_bytes(int thread, const void* where) {
  const std::size_t location = find(where, 0);
  if (view(thread)[location] < locations_[location].last_write) raced_ = true;
  append(thread, location, 0, memory_order::relaxed, {});
}

void WeakMemory::write_bytes(int thread, const void* where) {
  const std::size_t location = find(where, 0);
  if (view(thread)[location] + 1U < locations_[location].stores.size()) raced_ = true;
  append(thread, location, 0, memory_order::relaxed, {});
  locations_[location].last_write = view(thread)[location];
}

}  // namespace tims::sched

// The cost of a process: CPU time, sleeps, memory.
#pragma once

#include <cstdint>

#include <sys/types.h>

namespace tims::bench {

struct Usage {
  double cpu_s = 0;
  double sleeps = 0;  // voluntary context switches: waits that really blocked

  Usage operator+(const Usage& other) const { return {cpu_s + other.cpu_s, sleeps + other.sleeps}; }
  Usage operator-(const Usage& before) const {
    return {cpu_s - before.cpu_s, sleeps - before.sleeps};
  }
};

Usage own_usage();
Usage usage_of(pid_t process);  // all its threads

double resident_mb(pid_t process);  // 10^6 bytes

// Prints the cost since `before` and the number of messages.
void print_usage(const Usage& before, std::uint64_t messages);

}  // namespace tims::bench

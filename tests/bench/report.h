// Output for people (table) and for programs (CSV).
#pragma once

#include <cstdio>
#include <fstream>
#include <map>
#include <string>

#include "tests/bench/metrics.h"
#include "tests/bench/scenarios.h"
#include "tims/result.h"

namespace tims::bench {

using ResultsByPeer = std::map<std::string, Metrics>;

// Printed to stdout, each case as soon as it is measured.
class Table {
 public:
  void print_head() const;
  void print(const Case& one, const ResultsByPeer& results);
  void print_summary() const;

 private:
  void print_row(const Case& one, const Row& row, const ResultsByPeer& results);
  void print_losses(const Case& one, const ResultsByPeer& results) const;

  int targets_ = 0;
  int met_ = 0;
};

// peer,scenario,payload_bytes,metric,value
class Csv {
 public:
  static Result<Csv> open(const std::string& path);  // an empty path: nothing is written
  void write(const Case& one, const ResultsByPeer& results);

 private:
  explicit Csv(std::ofstream file) : file_(std::move(file)) {}
  std::ofstream file_;
};

}  // namespace tims::bench

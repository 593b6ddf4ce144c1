#include "tests/bench/report.h"

#include <cmath>
#include <iterator>
#include <optional>

namespace tims::bench {
namespace {

std::string size_text(std::size_t payload) {
  if (payload == 0) return "";
  if (payload >= (1 << 20)) return std::to_string(payload >> 20) + " MiB";
  if (payload >= (1 << 10)) return std::to_string(payload >> 10) + " KiB";
  return std::to_string(payload) + " B";
}

std::string number_text(double value) {
  const char* unit = "";
  for (const char* larger : {"k", "M", "G"}) {
    if (std::fabs(value) < 1000) break;
    value /= 1000;
    unit = larger;
  }
  char text[32];
  std::snprintf(text, sizeof text, "%.3g%s", value, unit);
  return text;
}

bool more_is_better(const std::string& metric) { return metric.ends_with("_per_s"); }

// The factor by which it is worse than the limit.
double ratio_of(const std::string& metric, double value, double limit) {
  return more_is_better(metric) ? limit / value : value / limit;
}

std::optional<double> find(const ResultsByPeer& results, const std::string& peer,
                           const std::string& metric) {
  const auto metrics = results.find(peer);
  if (metrics == results.end()) return std::nullopt;
  const auto found = metrics->second.find(metric);
  if (found == metrics->second.end()) return std::nullopt;
  return found->second;
}

std::string target_text(const Target& target) {
  std::string text;
  if (target.ratio_max) text += "<= " + number_text(*target.ratio_max) + " x ";
  if (target.at_least) text += ">= " + number_text(*target.at_least) + " ";
  if (target.at_most) text += "<= " + number_text(*target.at_most) + " ";
  if (target.above_max) text += "<= reference + " + number_text(*target.above_max) + " ";
  if (!text.empty()) text.pop_back();
  return text;
}

bool meets(const Target& target, double value, std::optional<double> limit,
           std::optional<double> ratio) {
  if (target.ratio_max && (!ratio || *ratio > *target.ratio_max)) return false;
  if (target.above_max && (!limit || value > *limit + *target.above_max)) return false;
  if (target.at_least && value < *target.at_least) return false;
  return !target.at_most || value <= *target.at_most;
}

void print_line(const std::string (&cells)[9]) {
  std::printf("%-24s %-8s %-20s %-10s %8s  %-13s %8s %6s  %s\n", cells[0].c_str(), cells[1].c_str(),
              cells[2].c_str(), cells[3].c_str(), cells[4].c_str(), cells[5].c_str(),
              cells[6].c_str(), cells[7].c_str(), cells[8].c_str());
  std::fflush(stdout);
}

}  // namespace

void Table::print_head() const {
  print_line(
      {"scenario", "payload", "metric", "peer", "value", "reference", "value", "ratio", "target"});
}

void Table::print(const Case& one, const ResultsByPeer& results) {
  for (const Row& row : one.rows) print_row(one, row, results);
  print_losses(one, results);
}

void Table::print_row(const Case& one, const Row& row, const ResultsByPeer& results) {
  const auto value = find(results, row.peer, row.metric);
  const auto limit = find(results, row.limit, row.metric);
  std::optional<double> ratio;
  if (value && limit) ratio = ratio_of(row.metric, *value, *limit);
  std::string verdict = target_text(row.target);
  if (!verdict.empty()) {
    const bool met = value && meets(row.target, *value, limit, ratio);
    ++targets_;
    met_ += met ? 1 : 0;
    verdict += met ? ": met" : ": NOT met";
  }
  print_line({one.scenario, size_text(one.payload), row.metric, row.peer,
              value ? number_text(*value) : "-", row.limit, limit ? number_text(*limit) : "",
              ratio ? number_text(*ratio) : "", verdict});
}

// No scenario may lose messages.
void Table::print_losses(const Case& one, const ResultsByPeer& results) const {
  for (const auto& [peer, metrics] : results) {
    const auto lost = metrics.find("lost");
    if (lost == metrics.end() || lost->second == 0) continue;
    print_line({one.scenario, size_text(one.payload), "lost", peer, number_text(lost->second), "",
                "", "", "must be 0: NOT met"});
  }
}

void Table::print_summary() const {
  std::printf(
      "\n%d of %d targets met. Ratio: factor by which the value is worse than the reference.\n"
      "Values are medians; on a busy machine use ratios, not values.\n",
      met_, targets_);
}

Result<Csv> Csv::open(const std::string& path) {
  std::ofstream file;
  if (!path.empty()) {
    file.open(path);
    if (!file) return Error(Errc::kSystem, "cannot write " + path);
    file << "peer,scenario,payload_bytes,metric,value\n" << std::flush;
  }
  return Csv(std::move(file));
}

void Csv::write(const Case& one, const ResultsByPeer& results) {
  if (!file_.is_open()) return;
  for (const Contender& contender : one.contenders) {
    const auto metrics = results.find(contender.peer);
    if (!contender.in_csv || metrics == results.end()) continue;
    for (const auto& [name, value] : metrics->second) {
      file_ << contender.peer << ',' << one.scenario << ',' << one.payload << ',' << name << ','
            << value << '\n';
    }
  }
  file_ << std::flush;
}

}  // namespace tims::bench

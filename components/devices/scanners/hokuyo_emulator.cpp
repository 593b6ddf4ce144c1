#include "components/devices/scanners/hokuyo_emulator.h"

#include <charconv>
#include <numbers>

namespace rack::device::emulator {
namespace {

constexpr std::size_t kCharactersOfLine = 64;
constexpr std::size_t kColumnsBefore = 24;
constexpr std::uint32_t kCounterAtPowerOn = 0xFFF000;  // overflows after four seconds

int number(std::string_view digits) {
  int value = 0;
  std::from_chars(digits.data(), digits.data() + digits.size(), value);
  return value;
}

}  // namespace

std::vector<std::vector<std::uint16_t>> scans_of_log(std::string_view text, std::size_t most) {
  std::vector<std::vector<std::uint16_t>> scans;
  while (!text.empty() && scans.size() < most) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    std::vector<std::uint16_t> scan;
    for (std::size_t column = 0; !line.empty(); ++column) {
      line.remove_prefix(std::min(line.find_first_not_of(" \r"), line.size()));
      const std::size_t size = std::min(line.find(' '), line.size());
      if (size > 0 && column >= kColumnsBefore)
        scan.push_back(static_cast<std::uint16_t>(number(line.substr(0, size))));
      line.remove_prefix(size);
    }
    if (!scan.empty()) scans.push_back(std::move(scan));
  }
  return scans;
}

void Hokuyo::start(Time now, Output& out) {
  uses_scip2_ = settings_.language == HokuyoLanguage::kScip2;
  compares_clocks_ = false;
  baud_ = settings_.baud;
  out.set_baud(baud_);
  began_ = now;
  next_ = tims::kNever;
  line_.clear();
}

void Hokuyo::on_arrival(const Arrival& arrival, Output& out) {
  constexpr std::size_t kLongest = 48;
  for (const std::byte byte : arrival.bytes) {
    const char c = static_cast<char>(byte);
    if (c != '\n' && c != '\r') {
      line_ += c;
      continue;
    }
    if (!line_.empty() && line_.size() <= kLongest) answer(line_, arrival.last, out);
    line_.clear();
  }
}

void Hokuyo::answer(std::string_view question, Time now, Output& out) {
  answer_.clear();
  if (question == "SCIP2.0" && settings_.language == HokuyoLanguage::kScip1First) {
    uses_scip2_ = true;
    begin_answer(question, "0");
    send(out);
  } else if (uses_scip2_) {
    answer_scip2(question, now, out);
  } else {
    answer_scip1(question, now, out);
  }
}

// Sends the request, the status and, in SCIP 2, its sum.
void Hokuyo::begin_answer(std::string_view question, std::string_view status) {
  answer_ += question;
  answer_ += '\n';
  if (status.size() == 2)
    append_scip_line(answer_, status);
  else
    (answer_ += status) += '\n';
}

void Hokuyo::send(Output& out) {
  answer_ += '\n';
  out.send(std::as_bytes(std::span(answer_)));
}

void Hokuyo::append_fields(std::initializer_list<std::pair<std::string_view, std::string>> fields) {
  for (const auto& [name, text] : fields) {
    const std::string field = std::string(name) + ":" + text;
    answer_ += field;
    if (uses_scip2_) (answer_ += ';') += scip_sum(field);
    answer_ += '\n';
  }
}

void Hokuyo::answer_scip1(std::string_view question, Time now, Output& out) {
  const auto range = scip_range(question);
  if (range && question.size() == 9) {
    const bool is_within = range->last <= settings_.parameters.last;
    begin_answer(question, is_within ? "0" : "4");
    if (is_within) append_scan(*range, now, false);
  } else if (question.size() == 14 && question[0] == 'S') {
    begin_answer(question, "0");
    send(out);
    set_rate(question.substr(1, 6), out);
    return;
  } else if (question == "V") {
    begin_answer(question, "0");
    append_fields({{"VEND", "Hokuyo Automatic Co.,Ltd."}, {"SERI", settings_.serial_number}});
  } else if (question == "L0" || question == "L1") {
    begin_answer(question, "0");
  } else {
    begin_answer(question, "E");
  }
  send(out);
}

void Hokuyo::answer_scip2(std::string_view question, Time now, Output& out) {
  const ScipParameters& all = settings_.parameters;
  const auto range = scip_range(question);
  const std::string_view symbol = question.substr(0, 2);
  if (compares_clocks_ && symbol != "TM") {
    begin_answer(question, "0E");
  } else if (range && (range->first < all.first - all.front || range->last > all.last)) {
    begin_answer(question, "04");
  } else if (range && symbol[0] == 'M' && question.size() == 15) {
    begin_answer(question, "00");
    begin_measuring(question, now);
  } else if (range && symbol[0] == 'G') {
    begin_answer(question, "00");
    append_scan(*range, now, true);
  } else if (symbol == "QT" || symbol == "RS") {
    next_ = tims::kNever;
    begin_answer(question, "00");
  } else if (symbol == "BM") {
    begin_answer(question, measures() ? "02" : "00");
  } else if (question == "TM0" || question == "TM1" || question == "TM2") {
    compares_clocks_ = question != "TM2";
    next_ = tims::kNever;
    begin_answer(question, "00");
    std::string time;
    append_scip_number(time, counter(now), 4);
    if (question == "TM1") append_scip_line(answer_, time);
  } else if (symbol == "VV") {
    begin_answer(question, "00");
    append_fields({{"VEND", "Hokuyo Automatic Co.,Ltd."},
                   {"PROD", "SOKUIKI Sensor URG-04LX"},
                   {"FIRM", "3.1.00(18/Jan./2007)"},
                   {"PROT", "SCIP 2.0"},
                   {"SERI", settings_.serial_number}});
  } else if (symbol == "PP") {
    begin_answer(question, "00");
    append_fields({{"MODL", all.model},
                   {"DMIN", std::to_string(all.range_min)},
                   {"DMAX", std::to_string(all.range_max)},
                   {"ARES", std::to_string(all.steps_of_turn)},
                   {"AMIN", std::to_string(all.first)},
                   {"AMAX", std::to_string(all.last)},
                   {"AFRT", std::to_string(all.front)},
                   {"SCAN", std::to_string(all.turns_of_minute)}});
  } else if (symbol == "II") {
    begin_answer(question, "00");
    append_fields({{"MODL", all.model},
                   {"LASR", measures() ? "ON" : "OFF"},
                   {"SBPS", std::to_string(baud_) + "[bps]"},
                   {"STAT", "Sensor works well."}});
  } else if (symbol == "SS" && question.size() == 8) {
    const bool has_it = static_cast<std::uint32_t>(number(question.substr(2))) == baud_;
    begin_answer(question, has_it ? "03" : "00");
    send(out);
    if (!has_it) set_rate(question.substr(2), out);
    return;
  } else {
    begin_answer(question, "0E");
  }
  send(out);
}

void Hokuyo::set_rate(std::string_view digits, Output& out) {
  baud_ = static_cast<std::uint32_t>(number(digits));
  out.set_baud(baud_);
}

void Hokuyo::begin_measuring(std::string_view question, Time now) {
  constexpr std::size_t kSizeWithoutCount = 13;
  measuring_ = question.substr(0, kSizeWithoutCount);
  skipped_ = 1 + number(question.substr(12, 1));
  const int count = number(question.substr(kSizeWithoutCount));
  left_ = count == 0 ? -1 : count;
  next_ = now + skipped_ * turn();
}

void Hokuyo::on_timeout(Time now, Output& out) {
  if (next_ > now) return;
  if (left_ > 0) --left_;
  answer_.clear();
  const int remaining = std::max(0, left_);
  begin_answer(measuring_ + static_cast<char>('0' + remaining / 10) +
                   static_cast<char>('0' + remaining % 10),
               "99");
  append_scan(*scip_range(measuring_), next_, true);
  send(out);
  next_ = left_ == 0 ? tims::kNever : next_ + skipped_ * turn();
}

void Hokuyo::append_scan(const ScipRange& range, Time end, bool has_sums) {
  std::string time;
  append_scip_number(time, counter(end), 4);
  if (has_sums) append_scip_line(answer_, time);
  characters_.clear();
  for (int step = range.first; step <= range.last; step += range.cluster) {
    const Time when = end - turn() * (range.last - step) / settings_.parameters.steps_of_turn;
    std::uint32_t least = distance(step, when);
    for (int i = 1; i < range.cluster && step + i <= range.last; ++i) {
      const std::uint32_t next = distance(step + i, when);
      const auto code_max = static_cast<std::uint32_t>(settings_.parameters.range_min);
      if (next >= code_max && (next < least || least < code_max)) least = next;
    }
    const std::uint32_t largest = range.characters == 2 ? 0xFFF : 0x3FFFF;
    append_scip_number(characters_, std::min(least, largest), range.characters);
    if (range.has_intensities) append_scip_number(characters_, 1000 + least / 10, 3);
  }
  for (std::size_t at = 0; at < characters_.size(); at += kCharactersOfLine) {
    const std::string_view line = std::string_view(characters_).substr(at, kCharactersOfLine);
    if (has_sums)
      append_scip_line(answer_, line);
    else
      (answer_ += line) += '\n';
  }
  ++sent_;
}

std::uint32_t Hokuyo::distance(int step, Time when) const {
  const ScipParameters& all = settings_.parameters;
  if (!settings_.scans.empty()) {
    const auto& scan = settings_.scans[sent_ % settings_.scans.size()];
    const auto index = static_cast<std::size_t>(std::max(0, step - all.first));
    return index < scan.size() ? scan[index] : 0;
  }
  const double angle = (all.front - step) * 2 * std::numbers::pi / all.steps_of_turn;
  const double seen = settings_.sight(angle, 0, when);
  return seen > all.range_max ? 0 : static_cast<std::uint32_t>(std::lround(seen));
}

std::uint32_t Hokuyo::counter(Time now) const {
  const auto since = std::chrono::duration_cast<std::chrono::milliseconds>(now - began_);
  return (static_cast<std::uint32_t>(since.count()) + kCounterAtPowerOn) & 0xFFFFFF;
}

Duration Hokuyo::turn() const {
  return Duration(std::chrono::minutes(1)) / settings_.parameters.turns_of_minute;
}

}  // namespace rack::device::emulator

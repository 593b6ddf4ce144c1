#include "components/devices/scanners/scip.h"

#include <charconv>
#include <numbers>

namespace rack::device {
namespace {

constexpr char kScipEnd = '\n';
constexpr unsigned kZero = 0x30;  // character for 0
constexpr std::size_t kCharactersOfLine = 64;
constexpr std::string_view kData = "99";

// Removes the first line from `text` and returns it without its line end.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = text.find(kScipEnd);
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return line;
}

// Removes the checksum from the end. Returns false if it is wrong.
bool take_sum(std::string_view& line) {
  if (line.size() < 2) return false;
  const char sum = line.back();
  line.remove_suffix(1);
  return scip_sum(line) == sum;
}

bool is_question(std::string_view text) {
  constexpr std::size_t kShortest = 1;
  constexpr std::size_t kLongest = 48;
  return text.size() >= kShortest && text.size() <= kLongest &&
         std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
}

bool are_numbers(std::string_view characters) {
  unsigned wrong = 0;
  for (const char c : characters) wrong |= static_cast<unsigned char>(c) - kZero;
  return (wrong & ~0x3FU) == 0;
}

// Decodes characters that were checked with are_numbers().
template <int kCharacters>
std::int32_t value_of(const char* at) {
  unsigned value = 0;
  for (int i = 0; i < kCharacters; ++i)
    value = value << 6 | (static_cast<unsigned char>(at[i]) - kZero);
  return static_cast<std::int32_t>(value);
}

std::optional<int> decimal(std::string_view text, std::size_t begin, std::size_t size) {
  if (text.size() < begin + size) return std::nullopt;
  int number = 0;
  for (const char digit : text.substr(begin, size)) {
    if (digit < '0' || digit > '9') return std::nullopt;
    number = 10 * number + (digit - '0');
  }
  return number;
}

int field_number(const ScipAnswer& answer, std::string_view name, int otherwise) {
  const std::string_view text = scip_field(answer, name);
  int number = otherwise;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

}  // namespace

char scip_sum(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum += static_cast<unsigned char>(c);
  return static_cast<char>((sum & 0x3F) + kZero);
}

std::optional<std::uint32_t> scip_number(std::string_view characters) {
  if (!are_numbers(characters)) return std::nullopt;
  std::uint32_t number = 0;
  for (const char c : characters) number = number << 6 | (static_cast<unsigned char>(c) - kZero);
  return number;
}

void append_scip_number(std::string& out, std::uint32_t number, int characters) {
  for (int i = characters - 1; i >= 0; --i)
    out += static_cast<char>((number >> 6 * i & 0x3F) + kZero);
}

void append_scip_line(std::string& out, std::string_view text) {
  out += text;
  out += scip_sum(text);
  out += kScipEnd;
}

void ScipAnswers::add(const Arrival& arrival) {
  // So many bytes without the end of an answer are invalid and are discarded.
  if (buffer_.size() + arrival.bytes.size() > kLongest) clear();
  buffer_.add(arrival);
}

void ScipAnswers::clear() {
  buffer_.clear();
  searched_ = used_ = 0;
}

bool ScipAnswers::next(ScipAnswer& answer) {
  buffer_.consume(std::exchange(used_, 0));
  for (;;) {
    const auto bytes = buffer_.bytes();
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (!text.empty() && text.front() == kScipEnd) {
      buffer_.consume(1);
      continue;
    }
    const std::size_t end = text.find("\n\n", searched_);
    if (end == std::string_view::npos) {
      searched_ = text.empty() ? 0 : text.size() - 1;
      return false;
    }
    searched_ = 0;
    std::string_view rest = text.substr(0, end + 1);
    answer.began = buffer_.time_of(0);
    answer.question = take_line(rest);
    answer.status = take_line(rest);
    answer.data = rest;
    const bool has_sums = answer.status.size() == 3;
    const bool is_good = is_question(answer.question) &&
                         (has_sums ? take_sum(answer.status) : answer.status.size() == 1);
    if (is_good) {
      used_ = end + 2;
      return true;
    }
    ++broken_;
    buffer_.consume(end + 2);
  }
}

std::string_view scip_field(const ScipAnswer& answer, std::string_view name) {
  std::string_view lines = answer.data;
  while (!lines.empty()) {
    std::string_view line = take_line(lines);
    // "NAME:text;" and a checksum that excludes the semicolon; SCIP 1 has neither.
    if (answer.has_sums()) {
      if (line.size() < 2 || line[line.size() - 2] != ';') continue;
      const char sum = line.back();
      line.remove_suffix(2);
      if (scip_sum(line) != sum) continue;
    }
    if (!line.starts_with(name) || line.size() <= name.size() || line[name.size()] != ':') continue;
    line.remove_prefix(name.size() + 1);
    return line;
  }
  return {};
}

bool parse_scip_parameters(const ScipAnswer& answer, ScipParameters& parameters) {
  ScipParameters stated{.model = std::string(scip_field(answer, "MODL")),
                        .range_min = field_number(answer, "DMIN", -1),
                        .range_max = field_number(answer, "DMAX", 0),
                        .steps_of_turn = field_number(answer, "ARES", 0),
                        .first = field_number(answer, "AMIN", -1),
                        .last = field_number(answer, "AMAX", -1),
                        .front = field_number(answer, "AFRT", -1),
                        .turns_of_minute = field_number(answer, "SCAN", 0)};
  const bool is_whole = stated.range_min >= 0 && stated.range_max > 0 && stated.steps_of_turn > 0 &&
                        stated.first >= 0 && stated.last > stated.first && stated.front >= 0 &&
                        stated.turns_of_minute > 0;
  if (is_whole) parameters = std::move(stated);
  return is_whole;
}

std::optional<ScipRange> scip_range(std::string_view question) {
  const bool is_scip1 = question.size() == 9 && question[0] == 'G';
  constexpr std::array<std::string_view, 6> kQuestions = {"MD", "MS", "ME", "GD", "GS", "GE"};
  if (!is_scip1 && std::ranges::find(kQuestions, question.substr(0, 2)) == kQuestions.end())
    return std::nullopt;
  const std::size_t digits = is_scip1 ? 3 : 4;
  const std::size_t begin = is_scip1 ? 1 : 2;
  const auto first = decimal(question, begin, digits);
  const auto last = decimal(question, begin + digits, digits);
  const auto cluster = decimal(question, begin + 2 * digits, 2);
  if (!first || !last || !cluster || *last < *first) return std::nullopt;
  return ScipRange{.first = *first,
                   .last = *last,
                   .cluster = std::max(1, *cluster),
                   .characters = is_scip1 || question[1] == 'S' ? 2 : 3,
                   .has_intensities = question[1] == 'E'};
}

bool ScipScans::decode(const ScipAnswer& answer, LadarData& scan, std::uint32_t& counter) {
  const auto range = scip_range(answer.question);
  if (!range || range->values() > decltype(LadarData::points)::kMax) return false;
  if (!join(answer, counter)) return false;
  const std::size_t of_value =
      static_cast<std::size_t>(range->characters) * (range->has_intensities ? 2 : 1);
  if (characters_.size() != range->values() * of_value || !are_numbers(characters_)) return false;
  fill(*range, scan);
  return true;
}

// Joins the lines without their checksums and line ends.
bool ScipScans::join(const ScipAnswer& answer, std::uint32_t& counter) {
  std::string_view lines = answer.data;
  characters_.clear();
  counter = 0;
  // Status of answers with data: G 0, GD and GS 00, MD and MS 99.
  if (answer.has_sums()) {
    const bool has_data =
        answer.status == kData || (answer.question[0] == 'G' && answer.status == "00");
    std::string_view time = take_line(lines);
    if (!has_data || !take_sum(time) || time.size() != 4) return false;
    const auto number = scip_number(time);
    if (!number) return false;
    counter = *number;
  } else if (answer.status != "0") {
    return false;
  }
  while (!lines.empty()) {
    std::string_view line = take_line(lines);
    if (answer.has_sums() && !take_sum(line)) return false;
    if (line.size() > kCharactersOfLine || characters_.size() + line.size() > kCharactersMax)
      return false;
    characters_ += line;
  }
  return true;
}

void ScipScans::fill(const ScipRange& range, LadarData& scan) const {
  const std::size_t count = range.values();
  const double step = 2 * std::numbers::pi / parameters_.steps_of_turn;
  // Combined steps have the angle of their middle.
  const double middle = range.first + (range.cluster - 1) / 2.0;
  const double first = start_angle_.value_or((parameters_.front - middle) * step);
  const double wide = step * range.cluster;

  scan.maxRange = parameters_.range_max;
  scan.duration = static_cast<u32>(60'000.0 / parameters_.turns_of_minute *
                                   (range.last - range.first + 1) / parameters_.steps_of_turn);
  scan.endAngle = static_cast<f32>(first);
  scan.startAngle = static_cast<f32>(first - static_cast<double>(count - 1) * wide);
  scan.points.resize(count);
  const char* at = characters_.data();
  for (std::size_t i = 0; i < count; ++i) {
    LadarPoint& point = scan.points[count - 1 - i];  // values are counterclockwise
    const std::int32_t value = range.characters == 2 ? value_of<2>(at) : value_of<3>(at);
    at += range.characters;
    point.intensity = range.has_intensities ? value_of<3>(at) : 0;
    if (range.has_intensities) at += 3;
    const bool is_code = value < parameters_.range_min;
    point.angle = static_cast<f32>(first - static_cast<double>(i) * wide);
    point.distance = is_code ? 0 : value;
    point.type =
        is_code || value > parameters_.range_max ? ladar_point::kInvalid : ladar_point::kUnknown;
  }
}

}  // namespace rack::device

#include "tools/timsctl/words.h"

#include <algorithm>
#include <string_view>

#include "router/config/nearest.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/option_table.h"
#include "tools/timsctl/verbs.h"

namespace timsctl {

namespace {

bool is_digit(char c) { return (c >= '0' && c <= '9') || c == '.'; }
// "-6"
bool is_number(std::string_view text) {
  return text.size() > 1 && std::ranges::all_of(text.substr(1), is_digit);
}

[[noreturn]] void refuse_unknown(std::string_view name) {
  std::vector<std::string_view> known;
  for (const OptionRow& row : option_table()) known.push_back(row.name);
  const auto near = tims::config::nearest(name, known);
  throw usage_error("no option --" + std::string(name),
                    near ? "did you mean --" + std::string(*near) + "?" : "`timsctl --help`");
}

class Splitter {
 public:
  explicit Splitter(std::span<const std::string> arguments) : rest_(arguments) {}

  Words split() {
    while (!rest_.empty()) {
      const std::string_view token = take();
      if (token == "--") return with_the_rest();
      if (token.starts_with("--")) {
        take_long(token.substr(2));
      } else if (token.starts_with('-') && token.size() > 1 && !is_number(token)) {
        take_letters(token.substr(1));
      } else {
        out_.words.emplace_back(token);
        if (a_command_follows()) return with_the_rest();
      }
    }
    return std::move(out_);
  }

 private:
  Words with_the_rest() {
    out_.words.insert(out_.words.end(), rest_.begin(), rest_.end());
    return std::move(out_);
  }

  // "sim exec HOST COMMAND...": the options of another program are not ours.
  [[nodiscard]] bool a_command_follows() const {
    if (out_.words.size() != 3) return false;
    try {
      const Resolved found = resolve(out_.words);
      return found.verb != nullptr && found.words == 2 &&
             found.verb->arguments.ends_with("COMMAND...");
    } catch (const Failure&) {
      return false;  // said later, when all words are known
    }
  }

  std::string_view take() {
    const std::string_view token = rest_.front();
    rest_ = rest_.subspan(1);
    return token;
  }

  void take_long(std::string_view token) {
    const std::size_t equals = token.find('=');
    const std::string_view name = token.substr(0, equals);
    if (name == "help" || name == "version") {
      out_.options.push_back("--" + std::string(name));
      return;
    }
    const OptionRow* row = find_option(name);
    if (row == nullptr) refuse_unknown(name);
    if (equals == std::string_view::npos) return add(*row, {}, false);
    if (row->value.empty()) throw usage_error("--" + std::string(name) + " takes no value");
    add(*row, token.substr(equals + 1), true);
  }

  // "-jw", "-n5", "-n 5", "-jn5", "-w0.5"
  void take_letters(std::string_view letters) {
    for (; !letters.empty(); letters.remove_prefix(1)) {
      if (letters.front() == 'h') {
        out_.options.emplace_back("--help");
        continue;
      }
      const OptionRow* row = find_option(letters.front());
      if (row == nullptr)
        throw usage_error("no option -" + std::string(1, letters.front()), "`timsctl --help`");
      const bool attached = letters.size() > 1 && (row->takes_value() || is_digit(letters[1]));
      if (!row->value.empty() && attached) return add(*row, letters.substr(1), true);
      add(*row, {}, false);
    }
  }

  void add(const OptionRow& row, std::string_view value, bool given) {
    std::string option = "--" + std::string(row.name);
    if (!row.value.empty()) {
      if (!given && row.takes_value()) {
        if (rest_.empty()) throw usage_error(option + " needs a value: " + std::string(row.value));
        value = take();
      } else if (!given) {
        value = row.value.substr(1, row.value.size() - 2);  // "[2]": the default
      }
      option.append("=").append(value);
    }
    out_.options.push_back(std::move(option));
  }

  std::span<const std::string> rest_;
  Words out_;
};

}  // namespace

Words split_words(std::span<const std::string> arguments) { return Splitter(arguments).split(); }

}  // namespace timsctl

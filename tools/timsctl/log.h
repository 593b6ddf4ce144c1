// timsctl log: selection and format of the texts of components.
#pragma once

#include <optional>

#include "proxies/gdos_texts.h"
#include "tools/cli/options.h"
#include "tools/cli/output.h"

namespace timsctl {

// A pattern of senders that is compared with their names: the widths of the fleet's addresses are
// not in the files of texts.
class SenderPattern {
 public:
  explicit SenderPattern(std::string_view text);  // throws Failure
  [[nodiscard]] bool matches(const rack::gdos::Record& record) const;

 private:
  struct Name {
    std::string class_name;
    std::string system;
    std::string instance;
    std::string local;
  };
  static std::optional<Name> name_of(std::string_view text, std::string_view local);

  std::optional<Name> name_;  // empty: one address, or all
  std::optional<tims::Address> address_;
};

struct TextFilter {
  std::optional<SenderPattern> component{};
  rack::gdos::Level level = rack::gdos::Level::kDetail;
  std::optional<rack::gdos::RecordTime> since{};
  std::optional<rack::gdos::RecordTime> until{};

  [[nodiscard]] bool passes(const rack::gdos::Record& record) const;
};
// The selection by --component, --level, --since and --until. Throws Failure.
TextFilter text_filter(const Options& options, rack::gdos::RecordTime now);

// "10min" (ago), "03:15", "2026-11-22", "2026-11-22 03:15:30", "2026-11-22T03:15:30.5Z": local time
// unless it ends with Z, or `utc`.
std::optional<rack::gdos::RecordTime> parse_when(std::string_view text, rack::gdos::RecordTime now,
                                                 bool utc);

// One line, coloured by level, or one line of JSON. `with_day`: for texts that are not live.
void show_text(Output& out, const rack::gdos::Record& record, bool with_day);

}  // namespace timsctl

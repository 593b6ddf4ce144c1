// What happens to programs that timsctl looks after: when, to whom and what, a line each, or an
// object of JSON.
#pragma once

#include <string_view>

#include "tims/time.h"
#include "tools/timsctl/context.h"

namespace timsctl {

class EventLines {
 public:
  EventLines(Context& context, std::string_view schema, int subject_width);

  // Times count from now on.
  void begin();
  [[nodiscard]] tims::Time began() const { return began_; }

  void say(std::string_view event, std::string_view subject, std::string_view text) const;

 private:
  Context& context_;
  std::string_view schema_;
  int subject_width_;
  tims::Time began_;
};

}  // namespace timsctl

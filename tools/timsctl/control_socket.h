// Something that runs in the foreground of one terminal is asked by timsctl in another: one record
// of JSON there, one back. Who listens is there; nothing else tells.
#pragma once

#include <functional>
#include <string>

#include "os/file.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/json.h"
#include "tools/timsctl/signals.h"

namespace timsctl {

bool somebody_listens(const std::string& path);
// Throws Failure: no answer in time, or what the other one threw. `nobody`: thrown when nobody
// listens.
json::object ask_control(const std::string& path, const json::object& question,
                         const Signals& signals, tims::Duration timeout, const Failure& nobody);

// Who asks. An answer is a promise kept once: to a question that ends everything, when it has.
class Asker {
 public:
  Asker() = default;
  explicit Asker(tims::os::File socket) : socket_(std::move(socket)) {}
  void answer(const json::object& answer);

 private:
  tims::os::File socket_;
};

// Takes the question that waits at a listener, if one does. What `handle` throws as Failure is
// answered; it may keep the asker and answer later.
void take_question(const tims::os::File& listener, const Signals& signals,
                   const std::function<void(const json::object& question, Asker& asker)>& handle);

// Empty when the text is no JSON object.
json::object parse_object(std::string_view text);

}  // namespace timsctl

// What a verb has at hand, and how most verbs do: they ask a router and show its answer.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include <fmt/format.h>

#include "tools/cli/admin_client.h"
#include "tools/cli/connection.h"
#include "tools/cli/options.h"
#include "tools/cli/output.h"

namespace timsctl {

class Context {
 public:
  Context(const Verb& what, const Options& command_line, Output& output, const Signals& interrupts,
          Host router)
      : verb(what),
        options(command_line),
        out(output),
        signals(interrupts),
        host(std::move(router)) {}

  const Verb& verb;
  const Options& options;
  Output& out;
  const Signals& signals;
  const Host host;

  // When it ends by itself, counted from now: --for. kNever: it does not.
  [[nodiscard]] tims::Time run_end() const;

  // A mailbox at the router. Throws Failure.
  [[nodiscard]] std::unique_ptr<Connection> connect(const MailboxRequest& request = {}) const;
  // Asks the router of the connection, or that of --router.
  [[nodiscard]] AdminClient admin(Connection& connection) const;
};

// Says so when messages came faster than a command could show them.
class LostMessages {
 public:
  // `what`: "messages".
  explicit LostMessages(std::string_view what) : what_(what) {}

  void note(const Connection& connection, const Output& out) {
    const std::uint64_t all = connection.missed();
    if (all == told_) return;
    out.note(fmt::format("{} {} were lost: too fast for this output, or larger than --body-max",
                         all - told_, what_));
    told_ = all;
  }

 private:
  std::string_view what_;
  std::uint64_t told_ = 0;
};

// --- Verbs that ask something and show the answer, once or again and again (--watch)

using AskRouter = std::function<json::object(AdminClient&)>;
// From the answer to what a person reads; never called for JSON.
using Draw = std::function<std::string(const json::object&, const Look&)>;

Exit show(Context& context, const AskRouter& ask, const Draw& draw);
// The answer's items as a table, or the answer as a page.
Draw table_of(std::span<const Column> columns);
Draw page_of(std::span<const Column> lines);

// A list: the answer's items as a table, ordered as --sort says.
Exit show_items(Context& context, const json::object& question, std::span<const Column> columns,
                const Draw& draw = {});
// A list that no router is asked for.
Exit show_list(Context& context, std::string_view schema, json::array items,
               std::span<const Column> columns);
// Of the router something is wanted; its answer is only shown as JSON.
Exit tell_router(Context& context, const json::object& question);

// The question with "match" for the first argument, if there is one.
json::object with_match(json::object question, const Options& options);

}  // namespace timsctl

// Questions that ask the router to change something (ADMIN.md): links up and down, faults, routes,
// logins, driving leases.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "router/core/router.h"
#include "router/io/admin_question.h"
#include "router/io/admin_source.h"
#include "wire/header.h"

namespace tims::io {

inline constexpr std::size_t kStaticRoutesMax = 256;

// For questions with Effect::kChanges: executes the request. Returns the answer.
std::string act(const Question& question, core::ClientId asker, AdminSource& source,
                const Clocks& clocks);

// For questions with Effect::kLogin: a login of at most the rights of the asker. Returns the
// answer.
std::string make_login(const Question& question, core::ClientId asker, AdminSource& source,
                       const Clocks& clocks);

// For questions with Effect::kDrives: who drives a robot. `request`: the header of the
// question. Returns the error if the lease is not changed.
std::optional<QuestionError> change_lease(const Question& question, core::ClientId asker,
                                          const Header& request, AdminSource& source, Time now);
// The answer after a lease has been changed.
std::string lease_text(const Question& question, const AdminSource& source, const Clocks& clocks);

// The static routes after a reload: the configured ones, as changed from `before` to `after`, and
// those added and deleted at run time.
std::vector<core::StaticRoute> reload_routes(const std::vector<core::StaticRoute>& running,
                                             const std::vector<core::StaticRoute>& before,
                                             const std::vector<core::StaticRoute>& after);

}  // namespace tims::io

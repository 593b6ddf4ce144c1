#include "router/core/labels.h"

#include "router/core/event.h"
#include "router/core/ids.h"
#include "router/core/neighbour.h"
#include "router/core/outcome.h"

namespace tims::core {

std::string_view name(Role role) { return label(kRoles, role).name; }
std::string_view name(LinkKind kind) { return label(kLinkKinds, kind).name; }

std::string_view name(PortKind port) { return label(kPortKinds, port).name; }

std::string_view name(Outcome outcome) { return label(kOutcomes, outcome).name; }
std::string_view sentence(Outcome outcome) { return label(kOutcomes, outcome).sentence; }

std::string_view name(EventKind kind) { return label(kEventKinds, kind).name; }
std::string_view sentence(EventKind kind) { return label(kEventKinds, kind).sentence; }

std::string_view name(CloseReason reason) { return label(kCloseReasons, reason).name; }
std::string_view sentence(CloseReason reason) { return label(kCloseReasons, reason).sentence; }

}  // namespace tims::core

// Texts in the journal of the host, with fields to look for:
//   journalctl TIMS_COMPONENT='Chassis(0/0)' -p warning
#pragma once

#include "proxies/gdos_texts.h"
#include "tims/result.h"

namespace rack::gdos_log {

// The priority of syslog: what `journalctl -p` counts.
int journal_priority(gdos::Level level);

// A host without a journal takes no notice. Pieces: MESSAGE, PRIORITY, SYSLOG_IDENTIFIER (the
// component), TIMS_ADDRESS, TIMS_COMPONENT, TIMS_LEVEL.
tims::Result<void> to_journal(const gdos::Record& record);

// Whether standard error goes there: a service of systemd.
bool runs_under_journal();

}  // namespace rack::gdos_log

// Replaces the engine when a router is built without Fast DDS.
#include "router/io/dds/dds_engine.h"

namespace tims::io {

class DdsEngine::Running {};

bool DdsEngine::built_in() { return false; }

DdsEngine::DdsEngine(Loop& loop, Log& log, DdsSettings settings, Listener& listener)
    : loop_(loop), log_(log), settings_(std::move(settings)), listener_(listener) {}

DdsEngine::~DdsEngine() = default;

Result<void> DdsEngine::start(const link::Announcement&) {
  return Error(Errc::kInvalidArgument, "this router was built without DDS (TIMS_WITH_DDS=OFF)");
}

void DdsEngine::restart(const link::Announcement&) {}
void DdsEngine::stop() {}
DdsEngine::State DdsEngine::state() const { return State::kOff; }
link::NetAddress DdsEngine::address() const { return {}; }
const std::string& DdsEngine::last_error() const { return last_error_; }
DdsEngine::Counters DdsEngine::counters() const { return {}; }
void DdsEngine::connect(const link::NetAddress&) {}
bool DdsEngine::send(const link::Burst&) { return false; }

}  // namespace tims::io

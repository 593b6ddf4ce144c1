#include "devices/emulators/echo.h"

namespace rack::device {

void Echo::on_arrival(const Arrival& arrival, Output& out) { out.send(arrival.bytes, arrival.id); }

}  // namespace rack::device

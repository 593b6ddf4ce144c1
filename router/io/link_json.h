// What links know, as JSON for the admin protocol.
#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>

#include "router/io/report_json.h"
#include "router/link/links.h"

namespace tims::io {

// One of the fleet's routers: who it is, what it is to us, whether it is there.
boost::json::object self_json(const link::Identity& self, const ProcessReport& process);
boost::json::object router_json(const link::Link& link, Time now);
// One that was announced by a link until that went down.
boost::json::object missing_json(const core::MissingRouter& missing, const AddressWidths& widths,
                                 Time now);

// One link, with all that can be seen of it.
boost::json::object link_json(const link::Links& links, const link::Link& link,
                              const core::Router& router, Time now);

// A router that announces itself in the fleet, and the engine that heard it.
boost::json::object announcement_json(const link::Links& links,
                                      const link::Announcement& announcement);
boost::json::object dds_json(const DdsReport& dds);

}  // namespace tims::io

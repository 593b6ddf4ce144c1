// Faults that somebody has injected into what a router sends over a link (`timsctl sim fault
// --link`). Pure.
#pragma once

#include <string>

#include <boost/json/object.hpp>

namespace timsctl {

// Of an item of tims/link/1: "10% lost, 20.00ms late"; empty: none.
std::string injected_faults(const boost::json::object& link);

}  // namespace timsctl

// Boost.JSON is used as source: everything it needs is compiled here, once.
#include <boost/json/src.hpp>

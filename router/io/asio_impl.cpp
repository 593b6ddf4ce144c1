// Boost.Asio is compiled here, once; everything else includes declarations only.
#include <boost/asio/impl/src.hpp>

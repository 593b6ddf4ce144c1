// Boost.Asio is compiled here; all other files include only its declarations.
#include <boost/asio/impl/src.hpp>

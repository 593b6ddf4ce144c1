// Shows a text that is longer than the terminal page by page.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace timsctl {

// Number of rows that the text needs on a terminal of that width; escape codes need none.
std::size_t rows_of(std::string_view text, std::size_t columns);

// Shows the text with $TIMS_PAGER, $PAGER or less, and returns when the user leaves it. False: it
// was not shown, because it fits on the terminal, or there is no pager.
bool show_in_pager(std::string_view text);

}  // namespace timsctl

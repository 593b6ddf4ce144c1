#!/usr/bin/env bash
# install_test.sh BUILD: installs with a prefix of its own, looks whether everything is below it and
# names the right paths; then into a folder that is moved elsewhere, and builds a small project
# against it: with find_package and with pkg-config, shared and static, in C++ and in C.
set -euo pipefail
build=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() { echo "$*" >&2; exit 1; }
expect() { [[ -e $1 ]] || fail "not installed: $1"; }
expect_line() { grep -qE "$2" "$1" || fail "$1 has no line $2"; }

# Says what was wrong with the missing router, and names nothing it would need of the build tree.
run() {
  local output
  output=$("$@")
  [[ $output == *router* ]] || { echo "$*: unexpected: $output" >&2; exit 1; }
  echo "$(basename "$1"): $output"
}

# install PREFIX [VARIABLE=VALUE]: says what was installed.
install() { env "${@:2}" cmake --install "$build" --prefix "$1" | sed -n 's/^-- [A-Z][-a-z]*: //p'; }

own=$work/own
install "$own" >"$work/installed"
if grep -v "^$own/" "$work/installed"; then fail "outside of the prefix"; fi
units=$own/lib/systemd/system
expect_line "$units/tims-router.service" "^ExecStart=$own/bin/tims-router --config $own/etc/tims/router.toml"
expect_line "$units/tims-robot@.service" "^ExecStart=$own/bin/timsctl .* $own/etc/tims/robots/%i.toml"
expect_line "$units/gdos-log.service" "^ExecStart=$own/bin/gdos-log"
if grep -n '@[A-Z_]*@' "$units"/*; then fail "names that nobody replaced"; fi
for program in tims-router timsctl gdos-log; do expect "$own/bin/$program"; done
for program in timsctl-robot timsctl-sim; do expect "$own/libexec/tims/$program"; done
"$own/bin/timsctl" robot --json | grep -q tims/robots/1  # found there
expect_line "$own/share/man/man1/tims-router.1" '^tims-router .* routes messages'
expect_line "$own/share/man/man1/timsctl-msg-echo.1" '^\\fB\\-\\-filter'
[[ $(readlink "$own/bin/tims_router_tcp") == tims-router ]] || fail "no link tims_router_tcp"
echo "# mine" >"$own/etc/tims/router.toml"
install "$own" >"$work/installed"
expect_line "$own/etc/tims/router.toml" "^# mine$"

install /usr DESTDIR="$work/staged" >"$work/installed"
expect "$work/staged/etc/tims/router.toml"
expect_line "$work/staged/usr/lib/systemd/system/tims-router.service" \
  "^ExecStart=/usr/bin/tims-router --config /etc/tims/router.toml"
prefix=$work/moved
mv "$work/staged/usr" "$prefix"
grep -rlF "$build" "$prefix/lib" "$prefix/include" --include='*.cmake' --include='*.pc' \
  --include='*.h' && { echo "names the build tree" >&2; exit 1; }
for header in tims.h tims/session.h tims/mailbox.h; do expect "$prefix/include/$header"; done

libdir=$(dirname "$(find "$prefix" -name libtims.so)")
export LD_LIBRARY_PATH=$libdir

cmake -S "$here/outside" -B "$work/with-cmake" -DCMAKE_PREFIX_PATH="$prefix" >"$work/cmake.log"
cmake --build "$work/with-cmake" >>"$work/cmake.log" 2>&1 || { cat "$work/cmake.log"; exit 1; }
for program in component component_c; do run "$work/with-cmake/$program"; done
LD_LIBRARY_PATH='' run "$work/with-cmake/component_static"

export PKG_CONFIG_PATH=$libdir/pkgconfig
read -ra flags <<<"$(pkg-config --cflags --libs tims)"
read -ra static_flags <<<"$(pkg-config --cflags --libs --static tims | sed 's/-L[^ ]*//')"
g++ -std=c++20 -Wall -Wextra -Werror "$here/outside/component.cpp" "${flags[@]}" -o "$work/cpp"
gcc -std=c99 -Wall -Wextra -Werror "$here/outside/component.c" "${flags[@]}" -o "$work/c"
run "$work/cpp"
run "$work/c"
# Static, and without the shared library in sight.
mkdir "$work/static"
cp "$libdir/libtims.a" "$work/static"
gcc -std=c99 "$here/outside/component.c" -L"$work/static" "${static_flags[@]}" -o "$work/c_static"
LD_LIBRARY_PATH='' run "$work/c_static"

#!/usr/bin/env bash
# install_test.sh BUILD: installs with DESTDIR and a temporary prefix, and checks that all files are below both and
# contain the right paths; then moves this installation, and builds a small project with
# it: with find_package and with pkg-config, shared and static, in C++ and in C. Finally the tutorial and "Writing
# a driver" are followed with it: the templates of a component and of a driver (share/rack) are built, tested,
# installed, and run with the installed programs, which must know their messages.
set -euo pipefail
build=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() { echo "$*" >&2; exit 1; }
expect() { [[ -e $1 ]] || fail "not installed: $1"; }
expect_line() { grep -qE "$2" "$1" || fail "$1 has no line $2"; }

# What `tools/dev build` builds is all that is installed.
ninja -C "$build" -t commands programs | tr ' ' '\n' | grep -E '^(bin|lib)/' | sort -u >"$work/built"
find "$build" -name cmake_install.cmake -exec grep -hoE "\"$build/(bin|lib)/[^\";]+\"" {} + |
  sed "s|\"||g; s|$build/||" | grep -v tims_router_tcp | sort -u >"$work/wanted"
(($(wc -l <"$work/wanted") > 50)) || fail "only $(wc -l <"$work/wanted") files of the build are installed"
if comm -13 "$work/built" "$work/wanted" | grep .; then fail "the target programs does not build these"; fi

# Runs a program without a router: it must report that, and not depend on the build tree.
run() {
  local output
  output=$("$@")
  [[ $output == *router* ]] || { echo "$*: unexpected: $output" >&2; exit 1; }
  echo "$(basename "$1"): $output"
}

# install FOLDER PREFIX [ARGUMENT...]: with this DESTDIR; prints the installed files.
install() { DESTDIR=$1 cmake --install "$build" --prefix "${@:2}" | sed -n 's/^-- [A-Z][-a-z]*: //p'; }

own=$work/own
install "$work/staged" "$own" >"$work/installed"
if grep -v "^$work/staged$own/" "$work/installed"; then fail "files outside of the prefix"; fi
mv "$work/staged$own" "$own"
units=$own/lib/systemd/system
expect_line "$units/tims-router.service" "^ExecStart=$own/bin/tims-router --config $own/etc/tims/router.toml"
expect_line "$units/tims-robot@.service" "^ExecStart=$own/bin/timsctl .* $own/etc/tims/robots/%i.toml"
expect_line "$units/gdos-log.service" "^ExecStart=$own/bin/gdos-log"
expect_line "$units/tims-keys.service" "^ExecStart=$own/bin/timsctl key serve --keys $own/etc/tims/keys"
# Who may write the keys: the router its certificate and list, and it cannot read the authority's keys.
expect_line "$units/tims-router.service" "^ReadWritePaths=-$own/etc/tims/keys"
expect_line "$units/tims-router.service" "^InaccessiblePaths=-$own/etc/tims/keys/authority"
if grep -n '@[A-Z_]*@' "$units"/*; then fail "placeholders that were not replaced"; fi
# What a service could do to its host if it were taken over, as systemd rates it: from 0 to 10.
exposure() {
  systemd-analyze security --offline=true --no-pager --threshold="$2" "$units/$1.service" >"$work/exposure" ||
    fail "$1.service is more exposed than $2 tenths: $(tail -1 "$work/exposure")"
}
cp "$units/tims-robot@.service" "$units/tims-robot@scout.service"
exposure tims-router 20
exposure gdos-log 10
exposure tims-agent 15
exposure tims-keys 15
exposure tims-robot@scout 30
systemd-analyze verify "$units"/*.service "$units"/*.socket 2>&1 | tee "$work/verified"
[[ ! -s $work/verified ]] || fail "systemd-analyze verify complains"
rm "$units/tims-robot@scout.service"
for program in tims-router timsctl gdos-log LadarSickLms200 rack-emulate World; do expect "$own/bin/$program"; done
for program in timsctl-deploy timsctl-robot timsctl-sim tims-crash-report; do expect "$own/libexec/tims/$program"; done
expect "$own/libexec/tims/tims-router-dds"
if [[ -e $own/bin/CameraV4l ]]; then expect "$own/libexec/tims/rack-video-reader"; fi
"$own/bin/timsctl" robot --json | grep -q tims/robots/1  # found in the installation
# Small, because debug information is in files of its own.
size=$(du -sm --exclude=debug "$own" | cut -f1)
((size <= 64)) || fail "an installation without debug information is of $size MB"
for file in bin/World lib*/tims/librack-common-*.so; do
  id=$(readelf -n "$own"/$file | sed -n 's/.*Build ID: //p')
  expect "$own/lib/debug/.build-id/${id:0:2}/${id:2}.debug"
done
expect_line "$own/share/man/man1/tims-router.1" '^tims-router .* routes messages'
expect_line "$own/share/man/man1/timsctl-msg-echo.1" '^\\fB\\-\\-filter'
expect_line "$own/lib/udev/rules.d/60-rack.rules" '^LABEL="rack_end"$'
for robot in sim base pioneer outdoor; do expect "$own/share/tims/robots/$robot.toml"; done
# All files and programs that robots, worlds and fleets refer to are installed as well; without OpenCV
# all but those with pictures.
is_with_pictures() { [[ $1 =~ ^(Camera.*|ObjRecogMarkers|ObjRecogPeople|map-maker|camera-calibrate)$ ]]; }
has_pictures=$([[ -e $own/bin/CameraV4l ]] && echo yes || echo no)
named=0
for file in "$own"/share/tims/{robots,worlds,fleets}/*.toml; do
  text=$(sed 's/#.*//' "$file")
  for name in $(grep -oE '[^ "=]+\.(toml|dxf|txt|yaml|pgm)' <<<"$text"); do
    [[ -e $(dirname "$file")/$name ]] || fail "$file names $name, which is not installed"
    named=$((named + 1))
  done
  for program in $(grep -oP '(program|command) = "\K(nice -n [-0-9]+ )?[^" ]+' <<<"$text" | sed 's/.* //') \
    $(grep -oP '"\K(timsctl|tims-demo|World)(?= )' <<<"$text"); do
    if [[ $has_pictures == no ]] && is_with_pictures "$program"; then continue; fi
    [[ -x $own/bin/$program ]] || fail "$file names $program, which is not installed"
    named=$((named + 1))
  done
done
((named > 50)) || fail "the samples refer to only $named files and programs"
[[ $(readlink "$own/bin/tims_router_tcp") == tims-router ]] || fail "no link tims_router_tcp"
echo "# mine" >"$own/etc/tims/router.toml"
install "" "$own" --component services >"$work/installed"
expect_line "$own/etc/tims/router.toml" "^# mine$"

install "$work/staged" /usr --component services >"$work/installed"
expect "$work/staged/etc/tims/router.toml"
expect_line "$work/staged/usr/lib/systemd/system/tims-router.service" \
  "^ExecStart=/usr/bin/tims-router --config /etc/tims/router.toml"
prefix=$work/moved
mv "$own" "$prefix"
grep -rlF "$build" "$prefix/lib" "$prefix/include" --include='*.cmake' --include='*.pc' \
  --include='*.h' && { echo "an installed file contains a path of the build tree" >&2; exit 1; }
for header in tims.h tims/session.h tims/mailbox.h rack/module.h rack/data_module.h rack/partner.h rack/input.h \
  rack/codec/codec.h rack/proxies/chassis.h rack/thread.h rack/priority_mutex.h rack/devices/driver.h \
  rack/devices/device.h rack/devices/dialogue.h rack/devices/emulator.h; do expect "$prefix/include/$header"; done

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
# Static, without access to the shared library.
mkdir "$work/static"
cp "$libdir/libtims.a" "$work/static"
gcc -std=c99 "$here/outside/component.c" -L"$work/static" "${static_flags[@]}" -o "$work/c_static"
LD_LIBRARY_PATH='' run "$work/c_static"

# --- the kit

# Each header can be included alone, and includes no library except Boost and the core of fmt. Headers of libraries are read once for
# all; one that is forgotten is found by tools/check, which compiles what has changed by itself.
mkdir "$work/libraries"
(cd "$prefix/include" && grep -rhoE '^#include <[^>]+>' rack | sort -u | grep -v -E '<(rack|tims)[/.]') >"$work/libraries/libraries.h"
flags=(-std=c++20 -Wall -Wextra -Werror -I"$prefix/include" -I"$work/libraries")
g++ "${flags[@]}" -x c++-header "$work/libraries/libraries.h"
while read -r header; do
  printf '#include <%s>\n' libraries.h "$header" | g++ "${flags[@]}" -fsyntax-only -x c++ - || fail "$header cannot be included alone"
done < <(cd "$prefix/include" && find rack -name '*.h')
if grep -rnE '#include <(fmt|toml)' "$prefix/include" | grep -v '<fmt/core.h>'; then fail "heavy headers in public ones"; fi
for library in librack:RACK_0.2 librack-devices:RACK_DEVICES_0.2; do
  nm -D --defined-only --with-symbol-versions "$libdir/${library%:*}.so" >"$work/symbols"
  grep -q "${library#*:}" "$work/symbols" || fail "$library has no symbol versions"
  if c++filt <"$work/symbols" |
    grep -E ' [A-Z] (vtable for |typeinfo for )?(rack::(Unwinder|LifeCycle|RealTimeWatch|Listeners|device::(CaptureFile|Guard|StreamTransport))|tims::os)\b'; then
    fail "$library exports symbols that are not public"
  fi
done
read -ra flags <<<"$(pkg-config --cflags --libs rack)"
g++ -std=c++20 "$prefix/share/rack/template/thermometer_test.cpp" "${flags[@]}" -o "$work/kit"
"$work/kit"
read -ra device_flags <<<"$(pkg-config --cflags --libs rack-devices)"
g++ -std=c++20 -Wall -Wextra -Werror "$here/outside/devices.cpp" "${device_flags[@]}" -o "$work/devices"
"$work/devices"
# The examples need nothing else.
for example in "$here"/../../components/examples/*.cpp; do
  g++ -std=c++20 "$example" "${flags[@]}" -o "$work/example" || fail "$example cannot be built with the kit"
done
gcc -std=c11 -Wall -Wextra -Werror "$here/../../components/examples/sweeper.c" "${flags[@]}" -o "$work/example" ||
  fail "the example in C cannot be built with the kit"

# Formats of log texts are checked by the compiler: an argument missing, one of another type.
log_call() {
  echo "#include <rack/text_log.h>
    void f(rack::TextLog& log, tims::Address from) { log.warning($1); }" |
    g++ -std=c++20 -I"$prefix/include" -fsyntax-only -x c++ - 2>"$work/errors"
}
log_call '"{} of {}: {}", 1, "text", from' || { cat "$work/errors"; fail "a correct log text does not compile"; }
for call in '"{} of {}", 1' '"{:d}", "text"' '"{:x}", from'; do
  if log_call "$call"; then fail "a wrong log text compiles: $call"; fi
done

# The tutorial and "Writing a driver", word by word, with this installation as /usr/local: the first installs the
# component of the template.
follow() { "$here/../documents/follow" "$here/../documents/$1.toml" --build "$build" --usr-local "$prefix"; }
status=0
follow tutorial || status=$?
if ((status == 77)); then
  for template in template driver; do
    cp -r "$prefix/share/rack/$template" "$work/$template"
    {
      cmake -S "$work/$template" -B "$work/$template/build" -DCMAKE_PREFIX_PATH="$prefix"
      cmake --build "$work/$template/build"
      ctest --test-dir "$work/$template/build"
      cmake --install "$work/$template/build" --prefix "$prefix"
    } >"$work/component.log" 2>&1 || { cat "$work/component.log"; exit 1; }
  done
else
  ((status == 0)) || fail "docs/tutorial.md does not work"
  follow driver || fail "docs/writing-a-driver.md does not work"
fi
expect "$prefix/share/rack/messages/thermometer.json"
expect "$prefix/lib/systemd/system/thermometer.service"

export TIMS_ROUTER=unix:$work/router.sock XDG_RUNTIME_DIR=$work/run XDG_STATE_HOME=$work/state
mkdir -m 700 "$work/run"
unset TIMS_HOST RACK_MESSAGES
stop() { kill "${running[@]}" 2>/dev/null || true; wait "${running[@]}" 2>/dev/null || true; rm -rf "$work"; }
running=()
trap stop EXIT
"$prefix/bin/tims-router" --set "unix.path=$work/router.sock" --set tcp.listen=off --set http.listen=off \
  --set udp.listen=off >"$work/router.log" 2>&1 &
running+=($!)
cat >"$work/robot.toml" <<TEXT
[[component]]
program = "Thermometer"
parameters = { period = 50, limit = 300000, targetStatus = 1 }

[[component]]
program = "DatalogRec"
parameters = { logPathName = "$work/", logInfoFileName = "$work/list" }
TEXT
echo "0x00800000 heat.dat" >"$work/list"
cmp <(sed -n '/^\[/,$p' "$prefix/share/thermometer/robot.toml") <(sed -n 1,3p "$work/robot.toml") ||
  fail "the template's robot has changed: change this test too"
"$prefix/bin/timsctl" up "$work/robot.toml" >"$work/up.log" 2>&1 &
running+=($!)

# until_works COMMAND...: repeats the command until it succeeds, for 60 s at most; a failure prints its output.
until_works() {
  local end=$((SECONDS + 60))
  while ((SECONDS < end)); do
    if "$@" >"$work/last" 2>&1; then return; fi
    sleep 0.1
  done
  cat "$work/up.log" "$work/last" >&2
  fail "timeout: $*"
}
timsctl=$prefix/bin/timsctl
until_works "$timsctl" msg echo Thermometer/0/0 -n 1
"$timsctl" msg echo Thermometer/0/0 -n 1 --si >"$work/echo"
grep -qE 'Thermometer\(0/0\) data .*temperature 29[34](\.[0-9]+)? K, limit 300 K, tooHot 0, sampleNum' "$work/echo" ||
  { cat "$work/echo"; fail "msg echo does not know the fields"; }
grep -q '^Thermometer(0/0) ' <("$timsctl" component list) || fail "component list does not know the class"
"$timsctl" msg pub Thermometer/0/0 set_limit limit=290K
grep -q tooHot <("$timsctl" msg show Thermometer data) || fail "msg show does not know the fields"
hot() { "$timsctl" msg echo Thermometer/0/0 -n 1 | grep -q 'limit 290000 mK, tooHot 1'; }
until_works hot
"$timsctl" msg pub Datalog/0/0 set_log "logPathName=$work/" 'logInfo[0].moduleMbx=Thermometer/0/0' \
  'logInfo[0].logEnable=1' 'logInfo[0].maxDataLen=100' 'logInfo[0].filename=heat.dat'
"$timsctl" msg pub Datalog/0/0 on
recorded() { grep -qE '^[0-9]+ 29[0-9]{4} 290000 1 4 29' "$work/heat.dat"; }
until_works recorded
grep -q '^% Thermometer(0/0)$' "$work/heat.dat" || fail "the recording has no heading"
sed -n 2,3p "$work/heat.dat"

# The back-trace of an installed component names file and line, from the files with debug information.
kill -SEGV "$(pgrep -f "^$prefix/bin/DatalogRec ")"
traced() { grep -qE 'Module::run.* at module\.cpp:[0-9]+' "$work/up.log"; }
until_works traced

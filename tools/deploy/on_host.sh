# What `timsctl deploy` runs on a host, as root: sh -c THIS tims-deploy THIS VERB ID [ARGUMENT...]. Nothing has to be
# installed before, and a host never has another version of it. Every verb may be called again after the connection was lost.
# What a deployer says comes through stdin and is not believed: names are checked here, too. /var/lib/tims-deploy has
#   holder    who deploys: ID, time, name            next/     what is to be: files, wanted packages, plan, debs
#   phase     what the job is doing; none: nothing   snap/     what was there when the job began
#   result    of the last job: ID and its end        current/  what was deployed last
#   log       of the last job, error.log its reason  before/   what was there before that, for --undo
#   packages/ the repository that was carried here   reserve   room on the disk for going back
# Files are written beside their place, to the disk, and renamed.
set -eu
umask 077
export LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
script=$1 verb=$2 id=$3
own=/var/lib/tims-deploy etc=/etc/tims

say() { printf '%s\n' "$*"; }
fail() { printf 'tims-deploy: %s\n' "$*" >&2; exit 10; }

# write_file PATH [MODE]: from stdin; the complete old or the complete new text, whatever happens.
write_file() {
  cat >"$1.new" && chmod "${2:-600}" "$1.new" && sync "$1.new" && mv -fT "$1.new" "$1" && sync "$(dirname "$1")"
}

is_name() {
  case $1 in '' | *[!A-Za-z0-9._+~:%/-]* | /* | -* | .* | */.* | *//*) return 1 ;; esac
}

job_runs() { ! flock -s -n job.lock true; }
has_result() { [ -f result ] && [ "$(cut -d ' ' -f1 <result)" = "$id" ]; }

# hold: only one deployer at a time works here. One that has gone is forgotten after a minute, or at once if its job was interrupted.
hold() {
  who=$1
  if [ -f holder ]; then
    read -r other since other_who <holder || true
    if [ "$other" != "$id" ]; then
      ! job_runs || fail "busy: a deployment of $other_who is not over yet"
      age=$(($(date +%s) - since))
      [ -f phase ] || [ $age -lt 0 ] || [ $age -gt 60 ] || fail "busy: $other_who deploys here, or did less than a minute ago"
    fi
  fi
  say "$id $(date +%s) $who" | write_file holder
}

# mine: what is prepared here, or is being kept, is of this deployer.
is_mine() { [ "$(cat next/id 2>/dev/null || cat current/id 2>/dev/null)" = "$id" ]; }
mine() { is_mine || fail "busy: another deployment has begun here since"; }

# A command of this deployment can outlive its connection and keep the lock: it ends, with what it has started.
end_former() {
  read -r pid <lock || return 0
  tr '\0' ' ' 2>/dev/null <"/proc/$pid/cmdline" | grep -qF " $id " || return 0
  read -r _ _ _ _ group _ <"/proc/$pid/stat" || return 0
  kill -s TERM -- "-$group" || true
}

version_of() { dpkg-query -W -f '${db:Status-Abbrev} ${Version}' "$1" 2>/dev/null | sed -n 's/^[ih]i *//p'; }

# The files that can be deployed and are there. Links and what they lead to are not.
managed() {
  (cd "$1" 2>/dev/null && find router.toml router.d robots keys -maxdepth 1 -type f 2>/dev/null) |
    { grep -xE 'router\.toml|(router\.d|robots|keys)/[A-Za-z0-9_][A-Za-z0-9._-]*' || true; } | sort
}

# --- what is there

look() {
  say "arch $(dpkg --print-architecture)"
  say "free_kib $(df -Pk /var | awk 'NR == 2 { print $4 }')"
  dpkg-query -W -f 'package ${Package} ${Version} ${db:Status-Abbrev}\n' 'libtims*' 'librack*' 'tims-*' 'rack-*' timsctl \
    python3-tims 2>/dev/null || true
  [ ! -f phase ] || say "phase $(cat phase)"
  ! job_runs || say "running"
  [ ! -d before ] || say "undo"
  managed "$etc" | while read -r name; do
    text=-
    case $name in *.toml) [ "$(stat -c %s "$etc/$name")" -gt 60000 ] || text=$(od -An -v -tx1 <"$etc/$name" | tr -d ' \n') ;; esac
    say "file $name $(sha256sum <"$etc/$name" | cut -c1-64) $text"
  done
  [ ! -f current/manifest ] || sed 's/^/deployed /' current/manifest
  [ ! -d packages ] || (cd packages && sha256sum -- *.deb 2>/dev/null | sed 's/^/deb /') || true
  say "end"
}

# --- what is to be

# take SHA256 SIZE PATH: so many bytes of stdin.
take() {
  mkdir -p "$(dirname "$3")"
  head -c "$2" >"$3.part" || fail "disk: cannot write $own/$3"
  [ "$(sha256sum <"$3.part" | cut -c1-64)" = "$1" ] || { rm -f "$3.part"; fail "damaged: $3 did not arrive as it was sent"; }
  mv -f "$3.part" "$3"
}

# receive: lines of stdin, with the bytes of files behind theirs.
receive() {
  while read -r kind rest; do
    # shellcheck disable=SC2086
    case $kind in
      wanted) is_name "$rest" || fail "bad name of a package"; say "$rest" >>next/wanted ;;
      # Not file:, whose packages apt leaves where they are: nobody could go back to them later.
      source) say "${rest#:}" | sed 's#file:/#copy:/#g' >>next/source ;;
      keep) is_name "$rest" && mkdir -p "$(dirname "next/files/$rest")" && cp "$etc/$rest" "next/files/$rest" || fail "lost: $rest" ;;
      file) set -- $rest; is_name "$1" || fail "bad name of a file"; take "$2" "$3" "next/files/$1" ;;
      deb)
        set -- $rest
        case $1 in */*) fail "bad name of a package" ;; esac
        is_name "$1" || fail "bad name of a package"
        take "$2" "$3" "packages/$1"
        chmod 644 "packages/$1"
        ;;
      end) return 0 ;;
      *) fail "unknown: $kind" ;;
    esac
  done
  fail "damaged: the end is missing"
}

idle() {
  ! job_runs || fail "busy: the last deployment is not over yet"
  [ ! -f phase ] || fail "busy: the last deployment was interrupted"
  # It would put its former files over those deployed.
  ! grep -qs '"pending":' /var/lib/tims-agent/record.json ||
    fail "busy: a change of the configuration waits: timsctl config confirm, or undo"
}

stage() {
  idle
  rm -rf snap reserve stop result progress
  mkdir -p next
  # What apt has downloaded for a deployment that was cut off need not come again.
  find next -mindepth 1 -maxdepth 1 ! -name debs -exec rm -rf {} +
  say "$id" >next/id
  mkdir -p next/files next/debs/partial next/old packages
  chmod 755 next next/debs packages
  : >next/wanted
  receive
  managed next/files >next/owned # what a later deployment may remove
  managed next/files | sed -n 's#^robots/\(.*\)\.toml$#\1#p' >next/robots
}

apt() {
  apt-get -q -y -o Dir::Etc::SourceParts="$own/next/sources.d" -o Dir::Cache::archives="$own/next/debs" \
    -o DPkg::Lock::Timeout=120 -o Dpkg::Options::=--force-confdef -o Dpkg::Options::=--force-confold "$@"
}

# In the form of one line, or of several with names.
source_name() { if grep -q '^deb ' "$1"; then say tims-deploy.list; else say tims-deploy.sources; fi; }

sources() {
  mkdir -p next/sources.d next/only.d
  chmod 755 next/sources.d next/only.d
  for list in /etc/apt/sources.list.d/*; do
    case $list in */tims-deploy.* | */\*) ;; *) cp "$list" next/sources.d/ ;; esac
  done
  [ -f next/source ] || return 0
  name=$(source_name next/source)
  cp next/source "next/only.d/$name"
  cp next/source "next/sources.d/$name"
  chmod 644 next/sources.d/* next/only.d/*
  # Only this one: a host without Internet does not wait for the others.
  apt -o Dir::Etc::SourceList=/dev/null -o Dir::Etc::SourceParts="$own/next/only.d" -o APT::Get::List-Cleanup=0 \
    -o APT::Update::Error-Mode=any update >prepare.log 2>&1 || fail "apt: $(apt_error)"
}

# The first error is the cause of the others.
apt_error() {
  { grep '^E:' prepare.log || grep -E '^(Err|W):|dpkg: error|No space left' prepare.log | tail -n 1; } | head -n 1 | cut -c1-300
}

# What apt would do: name, version now (or -), version then.
simulate() {
  # shellcheck disable=SC2046
  apt -s install $(cat next/wanted) >prepare.log 2>&1 || return 1
  ! grep -q '^Remv ' prepare.log || fail "apt: it would remove $(sed -n 's/^Remv \([^ ]*\).*/\1/p' prepare.log | tr '\n' ' ')"
  awk '/^Inst / { old = "-"; new = $3
    if ($3 ~ /^\[/) { old = substr($3, 2, length($3) - 2); new = $4 }
    sub(/^\(/, "", new); print $2, old, new }' prepare.log >next/plan
}

# Debs of what is installed now and changes, without which nobody could go back.
keep_old() {
  while read -r name old _; do
    [ "$old" != - ] || continue
    full=$(say "$old" | sed 's/:/%3a/g')
    found=$(find current/debs packages /var/cache/apt/archives -maxdepth 1 \( -name "${name%:*}_${full}_*.deb" -o \
      -name "${name%:*}_${old#*:}_*.deb" \) 2>/dev/null | head -n 1)
    if [ -n "$found" ]; then
      cp "$found" next/old/ || fail "disk: no room for the packages of now"
    else
      (cd next/old && apt-get -q download "$name=$old") >/dev/null 2>&1 || say "$name=$old"
    fi
  done <next/plan >next/lost
  [ ! -s next/lost ] || [ "$1" = force ] ||
    fail "lost: no repository has what is installed now, so that nobody could go back: $(tr '\n' ' ' <next/lost)"
}

reserve() {
  rm -f reserve
  fallocate -l "$((2 * $(du -sk next/old | cut -f1) + 8192))KiB" reserve 2>/dev/null ||
    { rm -f reserve; fail "disk: /var has no room for an upgrade that can go back"; }
}

prepare() {
  : >next/plan
  if [ -s next/wanted ]; then
    sources
    simulate || { apt update >/dev/null 2>&1 || true; simulate || fail "apt: $(apt_error)"; }
    if [ -s next/plan ]; then
      # shellcheck disable=SC2046
      apt --download-only install $(awk '{ print $1 "=" $3 }' next/plan) >prepare.log 2>&1 || fail "apt: $(apt_error)"
      keep_old "$1"
    fi
  fi
  reserve
  sed 's/^/install /' next/plan
}

# undo: what was there before the last deployment becomes what is to be.
undo() {
  idle
  [ -d before ] || fail "nothing was deployed here before, so that there is nothing to go back to"
  rm -rf next snap stop result progress
  cp -al before next
  say "$id" | write_file next/id
  mkdir -p next/old
  say dpkg >next/how
  while read -r name to; do
    now=$(version_of "$name")
    [ "${now:--}" = "$to" ] || say "$name ${now:--} $to"
  done <before/packages >next/plan
  keep_old "$1"
  reserve
  sed 's/^/install /' next/plan
}

# --- the job: it goes on when the connection is lost, and ends with what is to be or with what was there

step() { say "$*" >>progress; }
# Not once it goes back, which is what a stop is for.
stopped() { [ -z "${goes_back:-}" ] && [ -e stop ]; }
phase() { say "$*" | write_file phase; }

is_active() { systemctl is-active --quiet "$1"; }
has_router() { [ -f /lib/systemd/system/tims-router.service ]; }
# robots FOLDER: the robots that it runs.
robots() { cat "$1/robots" 2>/dev/null || true; }

# owned FOLDER: the files that it has deployed, not those that were there without us.
owned() { cat "$1/owned" 2>/dev/null || true; }

# The files that change.
changes() {
  managed next/files >names || return 1
  while read -r name; do cmp -s "next/files/$name" "$etc/$name" || say "$name"; done <names
  owned current | grep -vxF -f names | while read -r name; do [ ! -f "$etc/$name" ] || say "$name"; done || true
}

snapshot() {
  [ ! -f snap/complete ] || return 0
  rm -rf snap
  mkdir -p snap/files snap/debs
  managed "$etc" | while read -r name; do
    mkdir -p "$(dirname "snap/files/$name")" && cp -p "$etc/$name" "snap/files/$name" || exit 1
  done || return 1
  awk '{ print $1, $2 }' next/plan >snap/packages && unknown_packages >snap/unknown && cp -al next/old/. snap/debs/ || return 1
  managed snap/files | sed -n 's#^robots/\(.*\)\.toml$#\1#p' | while read -r robot; do
    ! is_active "tims-robot@$robot" || say "$robot" || exit 1
  done >snap/robots || return 1
  ! has_router || ! is_active tims-router || : >snap/router || return 1
  owned current >snap/owned && failures >snap/failures || return 1
  # In one piece: a disk that is full now must not hide one of them.
  changed=$(changes) && printf %s "${changed:+$changed
}" >next/changes || return 1
  sync -f snap && : >snap/complete && sync snap/complete snap
}

# Packages of the plan of which this host has never had anything: when they go, their settings and records go, too. Those that
# programs without packages have left stay.
unknown_packages() {
  [ ! -e /var/lib/tims-agent ] && [ ! -e /var/log/tims ] || return 0
  while read -r name old _; do
    [ "$old" = - ] || continue
    case $(dpkg-query -W -f '${db:Status-Abbrev}' "$name" 2>/dev/null) in '' | un*) say "$name" ;; esac
  done <next/plan
}

# as_dpkg ARGUMENT...: waits for others who work with packages, two minutes at most.
as_dpkg() {
  tries=0
  until dpkg "$@" >dpkg.log 2>&1; do
    cat dpkg.log
    tries=$((tries + 1))
    grep -q 'locked by another process' dpkg.log && [ $tries -lt 120 ] || return 1
    sleep 1
  done
  cat dpkg.log
}

# set_packages FOLDER DEBS: the versions of the third column of its plan, also older ones; - is removed.
set_packages() {
  debs='' gone='' purged=''
  while read -r name _ to; do
    case $to in
      -)
        gone="$gone $name"
        ! grep -qxF "$name" "$1/unknown" || purged="$purged $name"
        ;;
      *) for deb in "$2/${name%:*}"_*.deb; do [ ! -f "$deb" ] || debs="$debs $deb"; done ;;
    esac
  done <"$1/plan"
  # shellcheck disable=SC2086
  [ -z "$debs" ] || as_dpkg --force-confdef --force-confold --auto-deconfigure -i $debs || return 1
  # shellcheck disable=SC2086
  [ -z "$gone" ] || as_dpkg --remove $gone || return 1
  # shellcheck disable=SC2086
  [ -z "$purged" ] || as_dpkg --purge $purged || return 1
}

install_packages() {
  [ -s next/plan ] || return 0
  step installing
  as_dpkg --configure -a || true # what an earlier run of this job had begun
  if [ -f next/how ]; then
    set_packages next next/debs
  else
    # shellcheck disable=SC2046
    apt --no-download install $(awk '{ print $1 "=" $3 }' next/plan)
  fi
}

# write_files FROM LIST: those of FROM; what only the list names goes. Of a snapshot, with their owners and modes.
write_files() {
  mkdir -p "$etc"
  for folder in "$etc" "$etc/router.d" "$etc/robots" "$etc/keys"; do
    [ ! -L "$folder" ] || { say "$folder is a link"; return 1; }
  done
  owner=root
  ! id tims >/dev/null 2>&1 || owner=tims
  managed "$1/files" >names || return 1
  while read -r name; do
    ! cmp -s "$1/files/$name" "$etc/$name" || continue
    folder=$(dirname "$etc/$name") mode=644 folder_mode=755
    case $name in keys/*) mode=600 folder_mode=700 ;; esac
    [ -d "$folder" ] || { mkdir -p "$folder" && chmod $folder_mode "$folder" && chown "$owner:" "$folder"; } || return 1
    temporary=$folder/.${name##*/}.new
    rm -f "$temporary" && cp -p "$1/files/$name" "$temporary" || return 1
    [ -f "$1/complete" ] || { chmod $mode "$temporary" && chown "$owner:" "$temporary"; } || return 1
    sync "$temporary" && mv -fT "$temporary" "$etc/$name" && sync "$folder" || return 1
  done <names
  grep -vxF -f names "$2" | while read -r name; do rm -f "$etc/$name"; done || true
}

# end_robots WANTED OTHER: robots of OTHER alone do not run any more. While their unit is there: it may go with its package.
end_robots() {
  for robot in $(robots "$2"); do
    robots "$1" | grep -qxF "$robot" || systemctl disable --now "tims-robot@$robot" >/dev/null 2>&1 || true
  done
}

# services FOLDER: its robots and the router run, with what is in force now.
services() {
  has_router || return 0
  systemctl daemon-reload || return 1
  again=''
  [ ! -s next/plan ] && ! grep -qE '^(router|keys)' next/changes || again=yes
  if [ -n "$again" ] || ! is_active tims-router; then
    step "restarting tims-router"
    systemctl enable tims-router && systemctl restart tims-router || return 1
  fi
  for robot in $(robots "$1"); do
    if [ -n "$again" ] || grep -q '^robots/' next/changes || ! is_active "tims-robot@$robot"; then
      step "restarting tims-robot@$robot"
      systemctl enable "tims-robot@$robot" && systemctl restart "tims-robot@$robot" || return 1
    fi
  done
}

doctor() { timsctl -H unix:/run/tims/router.sock doctor --json; }
# What doctor's answer calls a failure.
failures_in() { say "$1" | tr '{' '\n' | sed -n '/"level":"failure"/s/.*"id":"\([^"]*\)".*/\1/p' | sort -u; }
failures() {
  command -v timsctl >/dev/null || return 0
  failures_in "$(doctor 2>/dev/null)"
}

# What is not as it must be: FOLDER's services run, and doctor finds nothing that it has not found before.
problem() {
  has_router || return 0
  for unit in tims-router $(robots "$1" | sed 's/^/tims-robot@/'); do
    is_active "$unit" || { say "$unit does not run"; return 0; }
  done
  command -v timsctl >/dev/null || return 0
  status=0
  answer=$(doctor 2>/dev/null) || status=$?
  case $status in
    0) ;;
    1)
      found=$(failures_in "$answer")
      [ -n "$found" ] || { say "doctor: it fails, and does not say why"; return 0; }
      say "$found" | grep -vxF -f snap/failures | sed 's/^/doctor: /' | head -n 1
      ;;
    *) say "the router does not answer" ;;
  esac
}

# comes_up FOLDER: within the time that the deployer gives, and not only for a moment.
comes_up() {
  step checking
  end=$(($(date +%s) + patience)) good=0
  while [ $good -lt 2 ]; do
    ! stopped || { why=stopped; return 1; }
    why=$(problem "$1")
    if [ -z "$why" ]; then good=$((good + 1)); else good=0; fi
    [ -z "$why" ] || [ "$(date +%s)" -lt $end ] || return 1
    [ $good = 2 ] || sleep 1
  done
}

# log_error WHAT: with what the log says of it, the cause before its consequences.
log_error() {
  for pattern in 'No space left' 'dpkg: error|^E:|subprocess|Job for' .; do
    found=$(grep -E "$pattern" log | tr -d '\r' | if [ "$pattern" = . ]; then tail -n 1; else head -n 1; fi | cut -c1-200)
    [ -z "$found" ] || break
  done
  say "$1: $found"
}

finish() {
  rm -f reserve
  sync -f .
  # What cannot be written down is taken up by the next deployment.
  say "$id $*" | write_file result || return 1
  # On the disk before the rest goes, without which nothing can be taken up.
  rm -f phase && sync .
  rm -rf stop next snap holder names gone dpkg.log
}

# go_back REASON: whatever was done goes.
go_back() {
  # Before it is complete, nothing changes; and without it, nobody knows what was there.
  [ -f snap/complete ] || { finish "back $*"; return; }
  goes_back=yes
  rm -f reserve stop
  [ -f error.log ] || tail -n 8 log | tr -d '\r' >error.log
  phase "back $*"
  step "going back: $*"
  end_robots snap next
  as_dpkg --configure -a || true
  awk '{ print $1, "-", $2 }' snap/packages >snap/plan
  set_packages snap snap/debs || { finish "broken $*; its packages did not go back: $(log_error dpkg)"; return; }
  managed next/files >gone && write_files snap gone || { finish "broken $*; its files did not go back"; return; }
  # Where no router ran before, there is nothing to come up.
  if [ -f snap/router ]; then
    services snap || { finish "broken $*; its services did not go back"; return; }
    comes_up snap || { finish "broken $*; went back, but $why"; return; }
  fi
  finish "back $*"
}

keep() {
  rm -f reserve
  [ "$(cat phase)" = keeping ] || phase keeping || { go_back "disk: cannot write down that it is kept"; return; }
  if [ -d next ]; then
    mkdir -p next/kept
    for deb in next/debs/*.deb current/debs/*.deb; do
      [ -f "$deb" ] || continue
      # shellcheck disable=SC2046,SC2016
      set -- $(dpkg-deb -W --showformat='${Package} ${Version}' "$deb")
      [ "$(version_of "$1")" != "$2" ] || cp -lf "$deb" next/kept/
    done
    rm -rf next/debs next/old && mv next/kept next/debs
    (cd next/files && xargs -r sha256sum <../owned) >next/manifest
    if [ -f next/source ]; then
      list=/etc/apt/sources.list.d/$(source_name next/source)
      write_file "$list" 644 <next/source
      for other in /etc/apt/sources.list.d/tims-deploy.*; do [ "$other" = "$list" ] || rm -f "$other"; done
    fi
    for deb in packages/*.deb; do
      name=${deb#packages/}
      [ ! -f packages/Packages ] || grep -qxF -e "Filename: $name" -e "Filename: ./$name" packages/Packages || rm -f "$deb"
    done
    if [ -d snap ]; then rm -rf before && mv snap before; fi
    rm -rf current && mv next current
  fi
  finish kept
}

job() {
  trap '' HUP PIPE INT TERM
  set +e
  [ -f phase ] || { rm -f result error.log && : >log && phase applying; } ||
    { finish "back disk: cannot write down what is done"; return; }
  was=$(cat phase)
  case $was in
    keeping) keep; return ;;
    back*) go_back "${was#back }"; return ;;
  esac
  snapshot || { finish "back disk: cannot keep what is there now"; return; }
  stopped && { go_back stopped; return; }
  end_robots next current
  install_packages || { go_back "$(log_error packages)"; return; }
  stopped && { go_back stopped; return; }
  if [ -s next/changes ]; then
    step configuring
    owned current >gone && write_files next gone || { go_back "$(log_error files)"; return; }
    stopped && { go_back stopped; return; }
  fi
  services next || { go_back "$(log_error services)"; return; }
  comes_up next || { go_back "$why"; return; }
  # What was before the last change is still what --undo means.
  if [ -s next/plan ] || [ -s next/changes ] || [ ! -d current ]; then keep; else finish same; fi
}

# follow: what the job says, until its end. Few processes: those of a small host are needed for the job.
follow() {
  lines=0 ended=''
  while [ -z "$ended" ]; do
    ended=yes
    has_result || ! job_runs || ended=''
    if [ -f progress ]; then
      read_lines=0
      while IFS= read -r line; do
        read_lines=$((read_lines + 1))
        [ $read_lines -le $lines ] || say "step $line"
      done <progress
      lines=$read_lines
    fi
    [ -n "$ended" ] || sleep 0.2
  done
  if has_result; then
    say "result $(cut -d ' ' -f2- <result)"
  else
    say "result broken interrupted: its job has ended without a result; the next deployment lets it go back"
  fi
  [ ! -f error.log ] || sed 's/^/log /' error.log
}

apply() {
  patience=$1
  case $patience in '' | *[!0-9]*) fail "bad time" ;; esac
  # If it is over, the deployer did not hear it.
  has_result || [ "$verb" = recover ] || mine
  if ! has_result && ! job_runs; then
    # Without next/ it was being kept.
    [ -d next ] || [ -f phase ] || fail "interrupted: nothing is prepared any more"
    setsid sh -c "$script" tims-deploy "$script" job "$id" "$patience" </dev/null >>log 2>&1 9>&- &
    tries=0
    until job_runs || has_result || [ $tries = 600 ]; do tries=$((tries + 1)) && sleep 0.05; done
  fi
  exec 9>&-
  follow
}

# recover: a job that was interrupted, as by a power failure, goes back; one that had come up is kept.
recover() {
  if ! has_result && ! job_runs; then
    [ -f phase ] || { say "result same"; return; } # it has ended meanwhile
    [ "$(cat phase)" != applying ] || phase "back interrupted"
  fi
  apply "$1"
}

release() {
  if is_mine && ! job_runs && [ ! -f phase ]; then rm -rf next snap reserve stop; fi
  [ "$(cut -d ' ' -f1 holder 2>/dev/null)" != "$id" ] || job_runs || [ -f phase ] || rm -f holder
}

[ "$(id -u)" = 0 ] || fail "rights: needs root"
command -v dpkg-query >/dev/null || fail "system: this is no Debian"
mkdir -p "$own"
chmod 755 "$own"
cd "$own"
if [ "$verb" = job ]; then
  patience=$4
  exec 8>job.lock
  flock -w 5 8 || exit 0
  job 8>&- # what it starts does not keep the lock
  exit
fi
: >>job.lock
case $verb in
  look) look; exit ;;
  # Also for a job that has not begun yet.
  stop) [ ! -d next ] || ! is_mine || : >stop; exit 0 ;;
esac
exec 9>>lock
flock -n 9 || { end_former; flock -w 60 9 || fail "busy: another command of a deployment runs"; }
say $$ >lock
[ "$verb" != release ] || { release; exit; }
hold "$4"
case $verb in
  stage) stage ;;
  carry) mine; receive ;;
  prepare) mine; prepare "$5" ;;
  undo) undo "$5" ;;
  apply) apply "$5" ;;
  recover) recover "$5" ;;
  *) fail "unknown verb" ;;
esac

#!/usr/bin/env bash
# deploy_test.sh STORY BIN: timsctl deploy against two hosts with real sshd, apt, dpkg and our router. A host is a set of
# namespaces: its file system is that of this machine, with all changes in a tmpfs of its own; its services are started by a
# small systemctl; its packages are tiny ones, made here. Needs root; status 77 (skipped) where that is not possible.
set -euo pipefail

readonly STORY=$1
PATH=/usr/sbin:/sbin:$PATH

skip() { echo "skipped: $*"; exit 77; }
fail() { echo "FAILED: $*" >&2; show_logs >&2; exit 1; }
show_logs() {
  for host in main arm; do
    echo "--- log of $host"
    ssh -oConnectTimeout=2 root@$host tail -n 30 /var/lib/tims-deploy/log /run/units/*.log || true
  done
  tail -n 40 -- "$T"/*.out
}

# --- a host. In its own network namespace, then in the others, then in its own root.

readonly TIMS_PROGRAMS=$2
if [[ $STORY == host ]]; then
  folder=$3 name=$4 number=$5 caller=$6
  ip link add eth0 type veth peer name "$name" netns "$caller"
  nsenter -t "$caller" -n sh -c "ip address add 10.79.$number.1/24 dev $name && ip link set $name up"
  ip link set lo up
  ip address add "10.79.$number.2/24" dev eth0
  ip link set eth0 up
  exec unshare --mount --pid --fork --kill-child "$0" root "$TIMS_PROGRAMS" "$folder" "$name"
fi
if [[ $STORY == root ]]; then
  folder=$3 name=$4 root=$3/root
  mount --make-rprivate /
  mount -t tmpfs -o size="${DISK:-192m}" tmpfs "$folder/layer"
  mkdir "$folder"/layer/{upper,work}
  mount -t overlay overlay -o "lowerdir=/,upperdir=$folder/layer/upper,workdir=$folder/layer/work" "$root"
  mount -t proc proc "$root/proc"
  mount --rbind /dev "$root/dev"
  mount -t tmpfs tmpfs "$root/run"
  mkdir -p "$root/run/sshd" "$root$TIMS_PROGRAMS/../lib" "$root$(dirname "$folder")"
  mount --bind "$TIMS_PROGRAMS" "$root$TIMS_PROGRAMS"
  mount --bind "$TIMS_PROGRAMS/../lib" "$root$TIMS_PROGRAMS/../lib"
  mount --bind "$(dirname "$folder")" "$root$(dirname "$folder")"
  # Lists and tools of this machine that take time, and which nobody has to try here.
  mount -t tmpfs tmpfs "$root/var/lib/apt/lists"
  mount -t tmpfs tmpfs "$root/root" # each command would run ~/.bashrc of who runs this test
  rm -rf "$root"/etc/apt/sources.list* "$root/etc/tims" "$root/var/lib/tims-deploy" "$root"/etc/apt/apt.conf.d/*
  mkdir "$root/etc/apt/sources.list.d"
  if [[ -z ${PACKAGES:-} ]]; then
    # Not the packages of this machine either, whose records take most of the time of dpkg and apt.
    mkdir -p "$folder"/layer/dpkg/{info,triggers,updates}
    touch "$folder"/layer/dpkg/{available,status}
    mount --bind "$folder/layer/dpkg" "$root/var/lib/dpkg"
  fi
  install -m 755 "$(dirname "$folder")/systemctl" "$root/usr/local/bin/systemctl"
  chroot "$root" useradd --create-home --password '*' --shell /bin/sh pi
  [[ ! -d $root/etc/sudoers.d ]] || echo 'pi ALL=(ALL) NOPASSWD: ALL' >"$root/etc/sudoers.d/pi"
  echo ready >"$folder/ready"
  exec chroot "$root" /usr/sbin/sshd -D -e -f "$(dirname "$folder")/sshd_config"
fi

# Real packages need more room; all others have a disk that is soon full.
[[ $STORY != packages ]] || export DISK=1g
[[ $(id -u) == 0 ]] || skip "network and mount namespaces need root"
for tool in sshd dpkg-deb apt-ftparchive nsenter; do command -v $tool >/dev/null || skip "no $tool"; done
if [[ -z ${DEPLOY_TEST_NETWORK:-} ]]; then
  unshare --net --mount true 2>/dev/null || skip "no namespaces here"
  DEPLOY_TEST_NETWORK=own exec unshare --net --mount "$0" "$@"
fi
ip link set lo up

T=$(mktemp -d /tmp/deploy-test.XXXXXX)
readonly T
hosts=()
cleanup() {
  for host in "$T"/*.ssh; do ssh -oControlPath="$host" -O exit host 2>/dev/null || true; done
  for pid in "${hosts[@]}"; do kill -9 "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf "$T"
}
trap cleanup EXIT

# What is seen of systemd: units as processes, with their ids in /run/units.
cat >"$T/systemctl" <<SYSTEMCTL
#!/bin/sh
mkdir -p /run/units /run/tims
verb=\$1 now='' wants=/etc/systemd/system/multi-user.target.wants
shift
case \$1 in --quiet) shift ;; --now) now=yes && shift ;; esac
unit=\$1
runs() { [ -f "/run/units/\$unit" ] && kill -0 "\$(cat "/run/units/\$unit")" 2>/dev/null; }
end() {
  ! runs || { kill "\$(cat "/run/units/\$unit")"; while runs; do sleep 0.05; done; }
  rm -f "/run/units/\$unit"
}
begin() { setsid "\$@" </dev/null >>"/run/units/\$unit.log" 2>&1 & echo \$! >"/run/units/\$unit"; }
case \$verb in
  is-active) runs ;;
  restart)
    end
    case \$unit in
      tims-router)
        rm -f /run/tims/router.sock
        begin /usr/bin/tims-router --config /etc/tims/router.toml --set unix.path=/run/tims/router.sock
        until [ -S /run/tims/router.sock ]; do runs || exit 1; sleep 0.05; done ;;
      *) robot=\${unit#*@}; begin /usr/bin/timsctl -H unix:/run/tims/router.sock up "/etc/tims/robots/\$robot.toml" ;;
    esac ;;
  enable) mkdir -p "\$wants" && ln -sf "/lib/systemd/system/\$unit.service" "\$wants/\$unit.service" ;;
  disable) rm -f "\$wants/\$unit.service"; [ -z "\$now" ] || end ;;
esac
SYSTEMCTL

ssh-keygen -q -t ed25519 -N '' -f "$T/host_key"
ssh-keygen -q -t ed25519 -N '' -f "$T/id"
cat >"$T/sshd_config" <<CONFIG
HostKey $T/host_key
AuthorizedKeysFile $T/id.pub
StrictModes no
UsePAM no
PidFile none
LogLevel ERROR
CONFIG
cat >"$T/ssh_config" <<CONFIG
Host main
  HostName 10.79.1.2
Host arm
  HostName 10.79.2.2
  User $(command -v sudo >/dev/null && echo pi || echo root)
Host *
  User root
  IdentityFile $T/id
  IdentitiesOnly yes
  StrictHostKeyChecking no
  KexAlgorithms curve25519-sha256
  UserKnownHostsFile /dev/null
  LogLevel ERROR
CONFIG
mkdir "$T/bin"
printf '#!/bin/sh\nexec /usr/bin/ssh -F %s "$@"\n' "$T/ssh_config" >"$T/bin/ssh"
chmod 755 "$T/bin/ssh" "$T"
PATH=$T/bin:$PATH

# until_true TEXT COMMAND...: 60 s at most, for a busy machine.
until_true() {
  local text=$1 end=$((SECONDS + 60))
  shift
  until "$@" >/dev/null 2>&1; do
    [[ $SECONDS -lt $end ]] || fail "this does not come true: $text"
    read -rt 0.3 <> <(:) || true
  done
}

start_host() {
  local name=$1 number=$2
  mkdir -p "$T/$name"/{layer,root}
  unshare --net --uts "$0" host "$TIMS_PROGRAMS" "$T/$name" "$name" "$number" $$ >"$T/$name.out" 2>&1 &
  hosts+=($!)
}
# By one connection a host, which stays.
on() { local host=$1; shift; ssh -oControlMaster=auto -oControlPath="$T/%n.ssh" -oControlPersist=yes "root@$host" "$@"; }

# --- packages and robot

# package NAME VERSION FOLDER: of the files in $T/content; with its scripts.
package() {
  local name=$1 version=$2 folder=$3
  mkdir -p "$T/content/DEBIAN"
  printf 'Package: %s\nVersion: %s\nArchitecture: all\nMaintainer: test <t@example>\nDescription: test\n%s' "$name" "$version" \
    "${DEPENDS:+Depends: $DEPENDS
}" >"$T/content/DEBIAN/control"
  dpkg-deb -Zgzip -z1 --root-owner-group -b "$T/content" "$folder" >/dev/null
  rm -rf "$T/content"
}

# repository VERSION [POSTINST]: tims-router and timsctl of this version, and what else is in $T/more.
repository() {
  local version=$1 postinst=${2:-:} folder=$T/packages
  rm -rf "$folder" "$T/content"
  mkdir -p "$folder" "$T"/content/{usr/bin,lib/systemd/system,etc/tims,DEBIAN}
  ln -s "$TIMS_PROGRAMS/tims-router" "$T/content/usr/bin/tims-router"
  touch "$T/content/lib/systemd/system/tims-router.service"
  echo "# of the package, version $version" >"$T/content/etc/tims/router.toml"
  echo /etc/tims/router.toml >"$T/content/DEBIAN/conffiles"
  printf '#!/bin/sh\nset -e\n%s\n' "$postinst" >"$T/content/DEBIAN/postinst"
  chmod 755 "$T/content/DEBIAN/postinst"
  DEPENDS="tims-common (= $version)" package tims-router "$version" "$folder"
  mkdir -p "$T/content/usr/bin"
  ln -s "$TIMS_PROGRAMS/timsctl" "$T/content/usr/bin/timsctl"
  package timsctl "$version" "$folder"
  mkdir -p "$T/content/usr/share/tims-common"
  [[ -z ${BIG:-} ]] || truncate -s 300M "$T/content/usr/share/tims-common/big"
  package tims-common "$version" "$folder"
  (cd "$folder" && apt-ftparchive packages . >Packages)
}

robot() {
  mkdir -p "$T"/scout/{main,arm}/keys
  chmod 755 "$T"/scout/*
  cat >"$T/scout.toml" <<ROBOT
[deploy]
ssh = "main"
repository = "packages"
packages = ["tims-router", "timsctl"]
files = "scout/main"
[host.arm]
ssh = "arm"
files = "scout/arm"
[[component]]
command = "sleep 1000"
ROBOT
  for host in main arm; do
    printf '[router]\nname = "%s"\n[http]\nlisten = "off"\n' "$host" >"$T/scout/$host/router.toml"
    echo "a key of $host" >"$T/scout/$host/keys/identity.key"
  done
}

deploy() { "$TIMS_PROGRAMS/timsctl" deploy "$T/scout.toml" --no-color "$@" >"$T/deploy.out" 2>&1 </dev/null; }
expect_deploy() {
  local expected=$1 status=0
  shift
  deploy "$@" || status=$?
  [[ $status == "$expected" ]] || fail "timsctl deploy $*: status $status, not $expected"
}
said() { grep -qE "$1" "$T/deploy.out" || fail "timsctl deploy does not say: $1"; }
version() { on "$1" "dpkg-query -W -f '\${Version} \${db:Status-Abbrev}' tims-router"; }
is_version() { [[ $(version "$1") == "$2 ii " ]] || fail "$1 has tims-router $(version "$1"), not $2"; }
has() { on "$1" grep -q "'$3'" "/etc/tims/$2" || fail "$1: $2 is without $3: $(on "$1" cat "/etc/tims/$2")"; }
router_runs() { on "$1" timsctl -H unix:/run/tims/router.sock router show | grep -q "$1" || fail "no router on $1"; }
file_of() { on "$1" stat -c '"%U %a"' "/etc/tims/$2"; }
clean() {
  on "$1" "cd /var/lib/tims-deploy && ls" | grep -E '^(next|snap|phase|reserve|holder|stop)$' && fail "$1 has remains" || true
  [[ -z $(on "$1" "find /etc -maxdepth 3 -path '/etc/tims/*' -name '.*.new'") ]] || fail "$1 has temporary files"
}

start_host main 1
start_host arm 2
robot
repository 1.0
until_true "sshd of main answers" on main true
until_true "sshd of arm answers" on arm true

story_upgrade() {
  expect_deploy 0 --dry-run
  said 'install tims-router 1.0'
  said 'new robots/scout.toml'
  version main 2>/dev/null && fail "a dry run installs"
  clean main

  expect_deploy 0 --dry-run --json
  said '^\{"schema":"tims/deploy/1".*"host":"arm".*"outcome":"untouched","reason":"dry run"'
  expect_deploy 2 --on leg

  expect_deploy 0
  said 'main +deployed'
  said 'arm +deployed'
  for host in main arm; do
    is_version $host 1.0
    has $host router.toml "name = \"$host\""
    router_runs $host
    clean $host
  done
  [[ $(on arm stat -c %a /etc/tims/keys/identity.key) == 600 ]] || fail "the key can be read by others"
  grep -q 'a key of' "$T/deploy.out" && fail "a key is shown"
  on main systemctl is-active tims-robot@scout || fail "the robot does not run"
  on arm test -e /etc/tims/robots/scout.toml && fail "the arm has the robot file"

  expect_deploy 0
  said 'arm +unchanged'

  # What goes back is as its owner had left it.
  on arm "chown pi: /etc/tims/router.toml && chmod 640 /etc/tims/router.toml"
  repository 1.1
  echo '# newer' >>"$T/scout/arm/router.toml"
  echo 'another key' >"$T/scout/arm/keys/identity.key"
  expect_deploy 0
  said 'tims-router 1.0 -> 1.1'
  said '^\+# newer'
  said 'changed keys/identity.key'
  is_version arm 1.1
  has arm router.toml '# newer'
  has arm keys/identity.key 'another key'
  [[ $(file_of arm router.toml) == 'root 644' ]] || fail "a deployed file is $(file_of arm router.toml)"

  expect_deploy 0 --undo
  said 'tims-router 1.1 -> 1.0'
  is_version main 1.0
  is_version arm 1.0
  has arm keys/identity.key 'a key of arm'
  on arm grep -q newer /etc/tims/router.toml && fail "undo left the newer file"
  [[ $(file_of arm router.toml) == 'pi 640' ]] || fail "undo made the file $(file_of arm router.toml)"
  router_runs arm
  expect_deploy 0 --undo
  is_version arm 1.1
  has arm router.toml '# newer'

  # A renewed key stays, a changed file is not overwritten without being asked.
  on arm "echo renewed >/etc/tims/keys/identity.key"
  on main "echo '# by hand' >>/etc/tims/router.toml"
  expect_deploy 1
  said 'main +untouched.*router.toml; --force'
  said 'arm +untouched.*main could not be prepared'
  expect_deploy 0 --force --on main
  on main grep -q by.hand /etc/tims/router.toml && fail "--force did not overwrite"
  expect_deploy 0
  has arm keys/identity.key renewed
  clean arm
}

# Where apt finds packages, in its two forms; and rights.
story_forms() {
  repository 1.0
  sed -i "s#^repository = .*#repository = \"deb [trusted=yes] file:$T/packages ./\"#" "$T/scout.toml"
  expect_deploy 0
  is_version arm 1.0
  on arm test -f /etc/apt/sources.list.d/tims-deploy.list || fail "no tims-deploy.list"

  repository 1.1
  sed -i "s#^repository = .*#repository = '''\nTypes: deb\nURIs: file:$T/packages\nSuites: ./\nTrusted: yes\n'''#" "$T/scout.toml"
  expect_deploy 0
  is_version arm 1.1
  on arm "grep -qx 'Suites: ./' /etc/apt/sources.list.d/tims-deploy.sources" || fail "no tims-deploy.sources"
  on arm test -e /etc/apt/sources.list.d/tims-deploy.list && fail "tims-deploy.list stays"
  on arm apt-get -q update | grep -q "copy:$T/packages" || fail "apt does not know the repository"
  clean arm

  command -v sudo >/dev/null || { echo "without sudo: rights are not tried"; return 0; }
  on arm "sed -i 's/NOPASSWD: //' /etc/sudoers.d/pi"
  expect_deploy 1 --on arm
  said 'arm +untouched +rights: pi is not root there.*a password is required'
  on arm rm /etc/sudoers.d/pi
  expect_deploy 1 --on arm
  said 'arm +untouched +rights: pi is not root there'
}

story_goes_back() {
  expect_deploy 0
  # A package that does not configure, on one of two hosts.
  repository 1.1 'hostname -I | grep -q 10.79.1 || { echo "this host is wrong"; exit 1; }'
  expect_deploy 1
  said 'main +deployed'
  said 'arm +went_back +packages:'
  is_version main 1.1
  is_version arm 1.0
  router_runs arm
  clean arm

  # A router that does not come up.
  printf '[http]\nlisten = "10.99.99.99:8080"\n[security]\ninsecure = true\n' >>"$T/scout/arm/router.toml"
  sed -i '/^\[http\]$/{N;/off/d}' "$T/scout/arm/router.toml"
  expect_deploy 1 --on arm --timeout 5s
  said 'arm +went_back'
  on arm grep -q 10.99 /etc/tims/router.toml && fail "the file did not go back"
  router_runs arm
  robot

  # A file that is wrong is found before anything is done.
  echo 'nonsense = 1' >>"$T/scout/arm/router.toml"
  expect_deploy 1
  said 'arm: router.toml:.*nonsense'
  robot

  touch "$T/scout/arm/passwd"
  expect_deploy 1
  said 'arm: .*passwd is not deployed'
  rm "$T/scout/arm/passwd"
  mkdir "$T/scout/arm/robots"
  for number in {1..62}; do touch "$T/scout/arm/robots/$number.dxf"; done
  expect_deploy 0 --dry-run --on arm # 64 files
  touch "$T/scout/arm/robots/63.dxf"
  expect_deploy 1 --dry-run --on arm
  said 'more than 64 files'
  rm -r "$T/scout/arm/robots"

  # A disk that fills in the middle.
  BIG=yes repository 1.2
  expect_deploy 1 --on arm
  said 'arm +went_back +.*No space left'
  is_version arm 1.0
  router_runs arm
  clean arm
  repository 1.3
  expect_deploy 0
  is_version arm 1.3
}

# hold_in_the_middle VERSION OUT: deploys to arm in the background, as $deployer, until its package waits for /hold to go.
hold_in_the_middle() {
  repository "$1" "touch /run/configuring-$1; while [ -e /hold ]; do sleep 0.1; done"
  on arm touch /hold
  set -m # a shell without jobs starts them deaf to Ctrl-C
  "$TIMS_PROGRAMS/timsctl" deploy "$T/scout.toml" --on arm </dev/null >"$T/$2" 2>&1 &
  deployer=$!
  set +m
  until_true "the package is being configured" on arm test -e "/run/configuring-$1"
}

story_cut() {
  expect_deploy 0
  repository 1.1 'touch /run/configuring; while [ -e /hold ]; do sleep 0.1; done'
  on arm touch /hold

  # ssh breaks in the middle, and comes again.
  deploy &
  local deployer=$!
  until_true "the package is being configured" on arm test -e /run/configuring
  on arm "pkill -f '^sshd: (root|pi)'" || true
  until_true "it connects again" grep -q 'arm: applying: connection lost' "$T/deploy.out"
  on arm rm /hold
  wait $deployer || fail "it did not survive a broken connection"
  said 'arm +deployed'
  is_version arm 1.1

  # The deployer is killed; the host ends alone, and the next one finds it so.
  hold_in_the_middle 1.2 killed.out
  kill -9 $deployer
  wait $deployer || true
  until_true "its connections end" bash -c "! pgrep -f '^/usr/bin/ssh -F $T/ssh_config.*-M'"
  expect_deploy 1 --on arm
  said 'busy'
  on arm rm /hold
  until_true "the host ends alone" on arm test ! -e /var/lib/tims-deploy/phase
  expect_deploy 0
  said 'arm +unchanged'
  is_version arm 1.2

  # Ctrl-C in the middle: the host goes back.
  hold_in_the_middle 1.3 deploy.out
  kill -INT $deployer
  until_true "the host is told" on arm test -e /var/lib/tims-deploy/stop
  on arm rm /hold
  local status=0
  wait $deployer || status=$?
  [[ $status == 130 ]] || fail "Ctrl-C: status $status"
  said 'arm +went_back +stopped'
  is_version arm 1.2
  router_runs arm
  clean arm

  # A host that loses its power in the middle: everything of it is killed there.
  hold_in_the_middle 1.4 power.out
  kill -9 $deployer
  wait $deployer || true
  on arm "kill -9 \$(pgrep -f '[t]ims-deploy|[a]pt-get|[d]pkg|[p]ostinst'); rm /hold" || true
  expect_deploy 0
  said 'arm +deployed'
  is_version arm 1.4
  router_runs arm
  clean arm
}

# --- doctor

# gate HOST: doctor waits there while the condition in /hold is true, and fails without a reason while there is /mute.
gate() {
  on "$1" "cat >/usr/local/bin/timsctl && chmod 755 /usr/local/bin/timsctl" <<'GATE'
#!/bin/sh
case "$*" in *doctor*)
  while [ -e /hold ] && sh /hold; do touch /run/held; sleep 0.1; done
  [ ! -e /mute ] || exit 1 ;;
esac
exec /usr/bin/timsctl "$@"
GATE
}
readonly KEEPS_WHAT_IS_THERE='[ ! -e /var/lib/tims-deploy/snap/complete ]'
readonly CHECKS='[ -e /var/lib/tims-deploy/snap/complete ]'
readonly GOES_BACK='grep -q ^back /var/lib/tims-deploy/phase'

# hold_doctor CONDITION OUT: deploys to arm in the background, as $deployer, until doctor waits there; on arm rm /hold ends that.
hold_doctor() {
  on arm "rm -f /run/held; cat >/hold" <<<"$1"
  set -m
  "$TIMS_PROGRAMS/timsctl" deploy "$T/scout.toml" --timeout 2s --on arm </dev/null >"$T/$2" 2>&1 &
  deployer=$!
  set +m
  until_true "doctor waits" on arm test -e /run/held
}
# ends_with STATUS: the deployment in the background.
ends_with() {
  local status=0
  wait $deployer || status=$?
  [[ $status == "$1" ]] || fail "the deployment ends with status $status, not $1"
}

story_doctor() {
  # A first deployment that goes back leaves nothing, neither services nor records of packages: apt install is then the first one.
  gate main
  on main touch /mute
  expect_deploy 1 --on main --timeout 1s
  said 'main +went_back +doctor: it fails, and does not say why'
  [[ -z $(on main "dpkg-query -W -f '\${Package}\${db:Status-Abbrev} ' 2>/dev/null") ]] || fail "packages are left"
  on main "ls /etc/systemd/system/multi-user.target.wants" | grep tims-robot && fail "the robot is still enabled"
  on main test -e /etc/tims/router.toml && fail "router.toml is left"
  on main "rm /mute && dpkg -i /var/lib/tims-deploy/packages/*.deb" >/dev/null
  has main router.toml 'of the package'

  # A disk that is full at the end.
  expect_deploy 0
  gate arm
  echo '# newer' >>"$T/scout/arm/router.toml"
  hold_doctor "$CHECKS" deploy.out
  on arm "cat /dev/zero >/fill 2>/dev/null; rm /hold" || true
  ends_with 0
  said 'arm +deployed'
  clean arm
  on arm rm /fill

  # One that is full before it begins.
  echo '# newest' >>"$T/scout/arm/router.toml"
  hold_doctor "$KEEPS_WHAT_IS_THERE" deploy.out
  on arm "cat /dev/zero >/fill 2>/dev/null; rm /hold" || true
  ends_with 1
  said 'arm +went_back +disk: cannot keep what is there now'
  clean arm
  on arm rm /fill

  # Everything runs, and doctor finds what it has not found before. Ctrl-C while the host goes back changes nothing of that.
  printf '[[link]]\nkind = "super"\nto = "10.79.2.99:2010"\n[security]\ninsecure = true\n' >>"$T/scout/arm/router.toml"
  hold_doctor "$GOES_BACK" deploy.out
  kill -INT $deployer
  until_true "the host is told" on arm test -e /var/lib/tims-deploy/stop
  on arm rm /hold
  ends_with 130
  said 'arm +went_back +doctor: links.down'
  on arm grep -q 10.79.2.99 /etc/tims/router.toml && fail "the file did not go back"
  clean arm
}

# --- deployments that are cut off, and others that come between

# as ID VERB [MORE]: what a deployer sends to arm.
as() { on arm "sh $T/on_host.sh \"\$(cat $T/on_host.sh)\" $2 $1 somebody@else ${3:-''}"; }
refused() {
  local why=$1
  shift
  "$@" >"$T/refused.out" 2>&1 && fail "not refused: $*"
  grep -q "$why" "$T/refused.out" || fail "$*: $(cat "$T/refused.out")"
}

story_killed() {
  expect_deploy 0 --on arm
  gate arm

  # The power fails while the host notes what is there, of which nothing is on the disk yet.
  echo '# newer' >>"$T/scout/arm/router.toml"
  hold_doctor "$KEEPS_WHAT_IS_THERE" killed.out
  kill -9 $deployer
  wait $deployer || true
  on arm "kill -9 \$(pgrep -f '[t]ims-deploy')" || true
  on arm rm -r /hold /var/lib/tims-deploy/snap/files
  expect_deploy 0 --on arm --dry-run
  has arm router.toml 'name = "arm"'
  has arm keys/identity.key 'a key of arm'
  clean arm
  expect_deploy 0 --on arm

  # It fails when all is in its place but not noted.
  on arm "echo keeping >/var/lib/tims-deploy/phase"
  expect_deploy 0 --on arm
  said 'arm +unchanged'
  clean arm

  # Nobody applies what another one has prepared.
  cp "$(dirname "$0")/../../tools/deploy/on_host.sh" "$T/"
  as first stage <<<end
  refused 'busy: somebody@else deploys here' as second stage <<<end
  on arm "sed -i 's/ [0-9]* / 1 /' /var/lib/tims-deploy/holder" # it was lost a minute ago
  as second stage <<<end
  on arm "sed -i 's/ [0-9]* / 1 /' /var/lib/tims-deploy/holder"
  for verb in carry prepare 'apply 5'; do
    # shellcheck disable=SC2086
    refused 'another deployment has begun here since' as first $verb <<<end
  done
  as first release
  on arm test -d /var/lib/tims-deploy/next || fail "another deployment was removed"
  # What apt has downloaded stays for the next time.
  on arm "sed -i 's/ [0-9]* / 1 /' /var/lib/tims-deploy/holder; touch /var/lib/tims-deploy/next/debs/x.deb"
  as second stage <<<end
  on arm test -e /var/lib/tims-deploy/next/debs/x.deb || fail "packages would be downloaded again"
  # Ctrl-C before the job has begun.
  as second prepare
  as second stop
  as second apply 5 | grep -x 'result back stopped' || fail "the stop was forgotten"
  has arm router.toml 'name = "arm"'
  clean arm

  # ssh breaks while apt works, which would go on with the lock.
  on arm "cat >/usr/local/bin/apt-get && chmod 755 /usr/local/bin/apt-get && touch /hold-apt" <<'APT'
#!/bin/sh
if rm /hold-apt 2>/dev/null; then touch /run/apt-works; sleep 1000; fi
exec /usr/bin/apt-get "$@"
APT
  repository 1.1+2
  deploy --on arm &
  deployer=$!
  until_true "apt works" on arm test -e /run/apt-works
  on arm "pkill -f '^sshd: (root|pi)'" || true
  ends_with 0
  said 'arm: preparing: connection lost'
  is_version arm 1.1+2
  on arm test -e /var/lib/tims-deploy/packages/tims-router_1.1+2_all.deb || fail "its packages would be sent again"
}

# With real packages: $PACKAGES, and newer ones of the same in $NEWER (tools/packages).
story_packages() {
  local old new
  sed -i 's/^packages = .*/packages = ["tims-router", "timsctl", "rack-components"]/' "$T/scout.toml"
  sed -i 's/^command = .*/program = "ChassisSim"/' "$T/scout.toml"
  old=$(sed -n '/^Package: tims-router$/,/^$/s/^Version: //p' "$PACKAGES/Packages" | sort -V | tail -n 1)
  new=$(sed -n '/^Package: tims-router$/,/^$/s/^Version: //p' "$NEWER/Packages" | sort -V | tail -n 1)
  rm -rf "$T/packages"
  cp -r "$PACKAGES" "$T/packages"
  expect_deploy 0
  is_version arm "$old"
  router_runs arm
  until_true "the component of the packages is there" on main "timsctl -H unix:/run/tims/router.sock route show | grep -q Chassis"
  [[ $(on arm stat -c %U /etc/tims/keys/identity.key) == tims ]] || fail "the key does not belong to the router"
  rm -rf "$T/packages"
  cp -r "$NEWER" "$T/packages"
  expect_deploy 0
  is_version main "$new"
  is_version arm "$new"
  router_runs main
  expect_deploy 0 --undo
  is_version main "$old"
  router_runs main
  clean main
}

"story_$STORY"
echo "passed: $STORY"

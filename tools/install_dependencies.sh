#!/bin/sh
# Installs what is missing of Debian 12's packages: tools/install_dependencies.sh [build] [checks] [browser] [python]
# Silent when nothing is missing. Root is asked for, by sudo, only when something is.
set -eu

build="g++ cmake ninja-build pkg-config python3 libeigen3-dev libboost-math-dev coinor-libipopt-dev liblapack-dev libblas-dev libtomlplusplus-dev
  nlohmann-json3-dev libcli11-dev libfmt-dev libhdf5-dev libssl-dev libgtest-dev libbenchmark-dev"
checks="clang-format clang-tidy shellcheck"
browser="chromium"
python="python3-venv python3-dev"

wanted=
for group in "${@:-build}"; do
  case $group in
    build) wanted="$wanted $build" ;;
    checks) wanted="$wanted $checks" ;;
    browser) wanted="$wanted $browser" ;;
    python) wanted="$wanted $python" ;;
    *) echo "install_dependencies.sh: no group \"$group\"; known: build checks browser python" >&2; exit 2 ;;
  esac
done

if ! command -v dpkg-query >/dev/null 2>&1; then
  echo "This is not Debian: install what corresponds to $wanted" >&2
  exit 0
fi

# shellcheck disable=SC2016,SC2086 # the format is dpkg's, the list is words
installed=$(dpkg-query -W -f '${db:Status-Status}:${Package}\n' $wanted 2>/dev/null || true)
missing=
for package in $wanted; do
  case "
$installed
" in
    *"
installed:$package
"*) ;;
    *) missing="$missing $package" ;;
  esac
done
[ -n "$missing" ] || exit 0

command="apt-get update && apt-get install -y --no-install-recommends$missing"
if [ "$(id -u)" -eq 0 ]; then
  as_root=
elif command -v sudo >/dev/null 2>&1; then
  as_root=sudo
else
  printf 'Missing:%s\nOnly root can install them, and there is no sudo here. As root, run:\n  %s\n' "$missing" "$command" >&2
  exit 1
fi

echo "installing$missing" >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt() {
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=120 "$@" >>"$log" 2>&1
}
apt update || true # one stale source need not stop the rest; the install below decides
# shellcheck disable=SC2086 # a list of words
if ! apt install -y --no-install-recommends $missing; then
  cat "$log" >&2
  printf 'The installation failed (log above). To try by hand, as root:\n  %s\n' "$command" >&2
  exit 1
fi

#!/bin/sh
# Measures Lamprey and its peers in one run: tools/bench_peers.sh LAMPREY_BENCH [--quick] [ARGUMENTS OF LAMPREY_BENCH]
# Makes a virtual environment in peers/ beside LAMPREY_BENCH from PyPI (bench/peers/requirements.txt, about 1.4 GB), then runs
# LAMPREY_BENCH and bench/peers/steps.py, then bench/peers/maneuvers.py with the lamprey beside LAMPREY_BENCH; with --quick the
# last alone, and less of it. Exit code 7, before anything is measured, where the environment cannot be made or there is no
# compiler. LAMPREY_PEERS_PYTHON names the python3 to make it with.
set -eu
here=$(dirname "$(readlink -f "$0")")
lamprey_bench=${1:?the path of lamprey_bench}
shift
quick=
[ "${1:-}" != --quick ] || { quick=--quick && shift; }
scripts=$here/../bench/peers
requirements=$scripts/requirements.txt
beside=$(dirname "$lamprey_bench")
folder=$beside/peers
environment=$folder/environment
python=${LAMPREY_PEERS_PYTHON:-/usr/bin/python3} # Debian's own: a python3 earlier in PATH may be a broken shim
[ -x "$python" ] || [ -n "${LAMPREY_PEERS_PYTHON:-}" ] || python=python3

cannot() {
  echo "lamprey: bench --peers: $1" >&2
  exit 7
}

make_environment() {
  "$python" -c "import venv, ensurepip" 2>/dev/null ||
    cannot "no virtual environment without Python and its module venv; on Debian: apt-get install python3-venv"
  mkdir -p "$folder" || cannot "$folder cannot be made"
  rm -rf "$environment"
  echo "installing peers from PyPI into $environment" >&2
  "$python" -m venv "$environment" >"$folder/install.log" 2>&1 ||
    cannot "no virtual environment could be made; log: $folder/install.log"
  "$environment/bin/python" -m pip install --disable-pip-version-check --only-binary :all: --requirement "$requirements" \
    >>"$folder/install.log" 2>&1 ||
    cannot "pin, crocoddyl, mujoco, casadi and scipy could not be installed from PyPI; log: $folder/install.log"
  cp "$requirements" "$environment/installed.txt" # the last thing: an interrupted installation starts anew
}

cmp -s "$requirements" "$environment/installed.txt" || make_environment
command -v cc >/dev/null || cannot "no C compiler cc, which CasADi's functions are compiled with; on Debian: apt-get install gcc"
python=$environment/bin/python
status=0
if [ -z "$quick" ]; then
  rm -f "$folder/lamprey.json" "$folder/chains.json"
  "$lamprey_bench" --benchmark_out="$folder/lamprey.json" --benchmark_out_format=json --chains_out="$folder/chains.json" "$@"
  "$python" "$scripts/steps.py" "$folder/chains.json" "$folder/lamprey.json" || status=$?
fi
"$python" "$scripts/maneuvers.py" "$beside/lamprey" "$here/../examples" "$folder" $quick --diagram "$folder/maneuvers.svg" || status=$?
exit "$status"

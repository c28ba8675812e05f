#!/bin/sh
# Screenshot of a whole report page by headless Chromium: tools/screenshot_report.sh FILE.html OUT.png [WIDTH] [light|dark] [HEIGHT]
set -eu
[ $# -ge 2 ] || { echo "usage: $0 FILE.html OUT.png [WIDTH] [light|dark] [HEIGHT]" >&2; exit 2; }
page=$(realpath "$1")
width=${3:-1400}
height=${5:-5200}
# headless Chromium follows this switch for prefers-color-scheme
[ "${4:-light}" = dark ] && scheme=0 || scheme=1
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome) || {
  echo "screenshot_report.sh: needs chromium (apt install chromium)" >&2
  exit 7
}
profile=$(mktemp -d)
trap 'rm -rf "$profile"' EXIT
sandbox=
[ "$(id -u)" -ne 0 ] || sandbox=--no-sandbox # Chromium refuses to run as root otherwise
# shellcheck disable=SC2086 # an empty $sandbox must vanish
"$browser" --headless $sandbox --user-data-dir="$profile" --disable-background-networking --no-first-run \
  --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader --hide-scrollbars \
  --blink-settings=preferredColorScheme="$scheme" --window-size="$width,$height" --virtual-time-budget=4000 \
  --screenshot="$(realpath "$2")" "file://$page" 2>"$profile/log" || { cat "$profile/log" >&2; exit 1; }

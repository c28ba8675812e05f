#!/bin/sh
# Builds web/dist/ again from web/src/ and the packages pinned in web/package-lock.json. Needs node 18 or newer and npm.
set -eu
cd "$(dirname "$0")/../web"
for program in node npm; do
  command -v "$program" >/dev/null || { echo "build_web.sh: needs $program (apt install nodejs npm)" >&2; exit 7; }
done
npm ci --ignore-scripts --no-audit --no-fund --silent
node build.js
ls -l dist

#!/usr/bin/env bash
# Judges the Foxglove server with an independent client. GROUNDWAVE names the program; `cargo xtask live` builds and names one.
set -euo pipefail
cd "$(dirname "$0")/../../.."

environment=target/judges/live
lock=tests/judges/live/package-lock.json
mkdir -p "$environment"
if ! cmp -s "$lock" "$environment/installed.json"; then
  cp tests/judges/live/package.json "$lock" "$environment"
  (cd "$environment" && npm ci --ignore-scripts --no-audit --no-fund --silent)
  cp "$lock" "$environment/installed.json"
fi
cp tests/judges/live/judge.mjs tests/judges/topics.json "$environment"
GROUNDWAVE="${GROUNDWAVE:?names the program to judge}" node "$environment/judge.mjs"

#!/usr/bin/env bash
# Lets a client that others wrote judge the Foxglove server. GROUNDWAVE names a program built with
# `--features foxglove`; without it one is built.
set -euo pipefail
cd "$(dirname "$0")/../../.."

if [ -z "${GROUNDWAVE:-}" ]; then
  # With the whole workspace's features, as CI's tests: what they built is not built again.
  cargo build --locked --workspace --all-features --bin groundwave
  GROUNDWAVE=target/debug/groundwave
fi

environment=target/judges/live
lock=tests/judges/live/package-lock.json
mkdir -p "$environment"
if ! cmp -s "$lock" "$environment/installed.json"; then
  cp tests/judges/live/package.json "$lock" "$environment"
  (cd "$environment" && npm ci --ignore-scripts --no-audit --no-fund --silent)
  cp "$lock" "$environment/installed.json"
fi
cp tests/judges/live/judge.mjs "$environment"
GROUNDWAVE="$GROUNDWAVE" node "$environment/judge.mjs"

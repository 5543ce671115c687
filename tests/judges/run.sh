#!/usr/bin/env bash
# Lets the tools that others wrote judge recordings, in a Python environment of their own.
set -euo pipefail
cd "$(dirname "$0")/../.."

environment=target/judges
requirements=tests/judges/requirements.txt
if ! cmp -s "$requirements" "$environment/installed.txt"; then
  python3 -m venv --clear "$environment"
  "$environment/bin/pip" install --quiet --disable-pip-version-check -r "$requirements"
  cp "$requirements" "$environment/installed.txt"
fi

JUDGE_PYTHON="$PWD/$environment/bin/python" \
  cargo test --locked --test capture -- --ignored --nocapture tools_that_others_wrote_agree

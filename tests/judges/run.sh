#!/usr/bin/env bash
# Judges recordings with independent tools: a finished recording, a killed and recovered one, a converted capture, and
# a part of one; and a map of the floor.
set -euo pipefail
cd "$(dirname "$0")/../.."
root=$PWD

environment=target/judges/python
requirements=tests/judges/requirements.txt
# Of rerun-sdk only the program is wanted, without the 300 MB of libraries that its Python half needs.
rerun=tests/judges/rerun.txt
if ! cat "$requirements" "$rerun" | cmp -s - "$environment/installed.txt"; then
  python3 -m venv --clear "$environment"
  pip=("$environment/bin/pip" install --quiet --disable-pip-version-check)
  "${pip[@]}" -r "$requirements"
  "${pip[@]}" --no-deps -r "$rerun"
  cat "$requirements" "$rerun" > "$environment/installed.txt"
fi
core=target/judges/core
lock=tests/judges/core/package-lock.json
mkdir -p "$core"
if ! cmp -s "$lock" "$core/installed.json"; then
  cp tests/judges/core/package.json "$lock" "$core"
  (cd "$core" && npm ci --ignore-scripts --no-audit --no-fund --silent)
  cp "$lock" "$core/installed.json"
fi
cp tests/judges/core/judge.mjs "$core"

JUDGE_PYTHON="$root/$environment/bin/python" \
  cargo test --workspace --all-features --locked --test system -- --ignored --nocapture tools_that_others_wrote_agree
groundwave=${GROUNDWAVE:?names the program to judge; cargo xtask judges sets it}

work=$(mktemp -d)
trap 'kill "${pids[@]}" 2>/dev/null || true; rm -rf "$work"' EXIT
pids=()
cd "$work"

# Rerun's program reports its use over the network and may wait there without end; the variable CI switches that off.
rerun() {
  CI=1 timeout --kill-after=5 120 "$root/$environment/bin/rerun" "$@"
}

# A finished recording and a killed one, of robots that run fifty times as fast as real time.
for name in live killed; do
  channel=$([ $name = live ] && echo ber=3e-4 || echo ber=1e-3)
  "$groundwave" sim --seed 7 --pty "$name.pty" --time-factor 50 --channel "$channel" > /dev/null &
  pids+=($!)
done
for name in live killed; do
  until [ -e "$name.pty" ]; do sleep 0.1; done
done
"$groundwave" watch killed.pty --headless --tee killed.txt --record killed.mcap > /dev/null &
victim=$!
"$groundwave" record live.pty -o live.mcap --duration 6s --quiet
"$groundwave" export live.mcap --to raw -o live.txt --quiet
kill -9 $victim
wait $victim 2>/dev/null || true
"$root/$environment/bin/python" "$root/tests/judges/judge_mcap.py" killed.mcap --unfinished --raw killed.txt
"$groundwave" recover killed.mcap

"$groundwave" export "$root/captures/house-noisy.txt" --to mcap -o converted.mcap --quiet
cp "$root/captures/house-noisy.txt" converted.txt
"$groundwave" cut live.mcap --from 2 --to 4 -o part.mcap --quiet
"$groundwave" export part.mcap --to raw -o part.txt --quiet

for name in live killed converted part; do
  killed=$([ $name = killed ] && echo --killed || true)
  "$groundwave" export "$name.mcap" --to jsonl -o - > "$name.jsonl"
  echo "-- $name"
  "$root/$environment/bin/python" "$root/tests/judges/judge_mcap.py" "$name.mcap" \
    --raw "$name.txt" $killed --jsonl "$name.jsonl"
  timeout 120 node "$root/$core/judge.mjs" "$name.mcap" "$name.txt"
  # The tool reports errors but exits with 0.
  rerun mcap check --full "$name.mcap" > checked.txt 2>&1 || true
  if grep -q PROBLEM checked.txt || ! grep -q '^ok' checked.txt; then
    cat checked.txt
    exit 1
  fi
  rerun mcap convert "$name.mcap" -o "$name.rrd" > rerun.txt 2>&1 ||
    { cat rerun.txt; exit 1; }
  echo "rerun: $(grep -c '^ok' checked.txt) topics checked, $(stat -c %s "$name.rrd") bytes converted"
  [ $name = killed ] || "$groundwave" verify "$name.mcap" --raw "$name.txt" --quiet
done
"$groundwave" export "$root/captures/house-clean.txt" --to map -o 'a "map".yaml' --quiet
"$groundwave" export "$root/captures/house-clean.txt" --to map -o floor.png --quiet
for map in 'a "map".yaml' floor.yaml; do
  "$root/$environment/bin/python" "$root/tests/judges/judge_map.py" "$map"
done
echo "4 recordings, each judged by mcap, @mcap/core and rerun"

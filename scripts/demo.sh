#!/usr/bin/env bash
# The main job, end to end: simulates a capture of a translucent block, runs the pipeline on the session folder alone and
# scores the result against the truth the pipeline never saw. The last line on standard output is one JSON object.
#   scripts/demo.sh [--sample demo|wax1|wax2|marble|stone] [--out FOLDER] [-- options for `kappamu simulate`]
set -euo pipefail
cd "$(dirname "$0")/.."
sample=demo
out=
while (($#)); do
  case $1 in
    --sample) sample=${2:?--sample needs a name}; shift 2 ;;
    --out) out=${2:?--out needs a folder}; shift 2 ;;
    --) shift; break ;;
    -h | --help) sed -n '2,4s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) echo "demo: unknown option $1 (see --help)" >&2; exit 2 ;;
  esac
done
out=${out:-out/$sample}

scripts/build.sh release kappamu
kappamu=build/app/kappamu

if [[ -f $out/truth/truth.json && -f $out/simulate.json ]]; then
  echo "demo: capture of '$sample' already simulated in $out (remove that folder to start afresh)"
else
  echo "demo: simulating the capture of '$sample' into $out/session"
  mkdir -p "$out"
  "$kappamu" simulate --sample "$sample" -o "$out" --json "$@" >"$out/simulate.log"
  tail -n 1 "$out/simulate.log" >"$out/simulate.json"
fi

echo "demo: running the pipeline on $out/session"
status=0
"$kappamu" run "$out/session" -o "$out/run" --json >"$out/run.log" || status=$?
((status == 0 || status == 3)) || exit "$status"
tail -n 1 "$out/run.log" >"$out/run.json"

echo "demo: scoring against the truth"
"$kappamu" score "$out/run" --truth "$out/truth" --json >"$out/score.log"
tail -n 1 "$out/score.log" >"$out/score.json"

python3 scripts/demo_summary.py "$out"
echo "demo: look at the block under moving lights, and edit it (scripts/view-demo.txt plays such a session): $kappamu view $out/run --edits $out/edited" >&2
exit "$status"

#!/usr/bin/env bash
# Remakes every chart and table of docs/benchmarks.md on this machine: measures section by section into out/bench, then
# renews docs/images/bench-*.png and the tables between the page's markers. About half an hour; leave the machine alone.
#   scripts/bench.sh [--quick|--small] [--draw] [SECTION...]     headline kernels peers relaxation grids scaling iterations
# (default: these); inverse, or inverse-optimisers, -scores, -embedded, -patterns, -voxels, -montecarlo, -samples: fits; choices-
# regulariser, -loss, -held-out: what a fit's choices gain; uncertainty: its deviations proved
# --quick measures toy grids into out/bench-quick and leaves the page alone; --small: smaller blocks, of fits alone; --draw measures nothing. BENCH_UNDER holds
# words to put before each measurement, BENCH_KAPPAMU another program than build/app/kappamu.
set -euo pipefail
cd "$(dirname "$0")/.."
quick=() small=() draw=0 out=out/bench sections=()
while (($#)); do
  case $1 in
    --quick) quick=(--quick) out=out/bench-quick; shift ;;
    --small) small=(--small); shift ;;
    --draw) draw=1; shift ;;
    -h | --help) sed -n '2,8s/^# \{0,1\}//p' "$0"; exit 0 ;;
    -*) echo "bench: unknown option $1 (see --help)" >&2; exit 2 ;;
    *) sections+=("$1"); shift ;;
  esac
done
((${#sections[@]})) || sections=(headline kernels peers relaxation grids scaling iterations)
kappamu=${BENCH_KAPPAMU:-build/app/kappamu}
[[ -n ${BENCH_KAPPAMU:-} ]] || scripts/build.sh release
read -ra under <<<"${BENCH_UNDER:-}"
if ((!draw)); then
  for section in "${sections[@]}"; do
    echo "bench: $section"
    case $section in
      inverse) "${under[@]}" "$kappamu" bench inverse -o "$out" "${quick[@]}" "${small[@]}" ;;
      inverse-*) "${under[@]}" "$kappamu" bench inverse -o "$out" --section "${section#inverse-}" "${quick[@]}" "${small[@]}" ;;
      choices-*) "${under[@]}" "$kappamu" bench choices -o "$out" --subject "${section#choices-}" ;;
      uncertainty) "${under[@]}" "$kappamu" bench uncertainty -o "$out" ;;
      *) "${under[@]}" "$kappamu" bench forward -o "$out" --section "$section" "${quick[@]}" ;;
    esac
  done
fi
if compgen -G "$out/inverse-*.json" >/dev/null; then "$kappamu" bench inverse -o "$out" --draw >"$out/summary.log"; fi
if compgen -G "$out/forward-*.json" >/dev/null; then "$kappamu" --json bench forward -o "$out" --draw >"$out/summary.log"; fi
if ((${#quick[@]} == 0)); then
  mkdir -p docs/images
  cp "$out"/bench-*.png docs/images/
  python3 scripts/bench_tables.py "$out" docs/benchmarks.md
fi
if [[ -f $out/summary.log ]]; then tail -n 1 "$out/summary.log"; fi

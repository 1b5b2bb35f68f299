#!/usr/bin/env bash
# Measures subjects of `kappamu-studies` on this machine into out/bench, then renews pictures and tables of the pages in
# docs/. Leave the machine alone meanwhile.
#   studies/bench.sh [--quick|--small] [--draw] [SUBJECT|SUBJECT-SECTION...]     such as forward-peers inverse limits
# (default: forward, half an hour; `kappamu-studies --help` names subjects and sections). --quick: toy problems into
# out/bench-quick, the pages stay; --small: smaller problems; --draw: measure nothing. BENCH_UNDER holds words to put
# before each measurement, BENCH_KAPPAMU another program than build/app/kappamu-studies, BENCH_SLABS the data of slabs.
# SUBJECT gpu, alone: what a GPU is compared by, on the first one there is (else a processor), the most telling first; one
# that fails leaves the others. Page and records go into out/bench-gpu (with --quick, out/bench-gpu-quick).
set -euo pipefail
cd "$(dirname "$0")/.."
size=() pages=(docs/*.md) draw=0 out=out/bench wanted=() gpu=0 failed=()
while (($#)); do
  case $1 in
    --quick) size=(--quick) out=out/bench-quick pages=(); shift ;;
    --small) size=(--small); shift ;;
    --draw) draw=1; shift ;;
    -h | --help) sed -n '2,9s/^# \{0,1\}//p' "$0"; exit 0 ;;
    -*) echo "bench: unknown option $1 (see --help)" >&2; exit 2 ;;
    *) wanted+=("$1"); shift ;;
  esac
done
((${#wanted[@]})) || wanted=(forward)
if [[ ${wanted[*]} == gpu ]]; then
  out=${out/bench/bench-gpu} pages=() gpu=1
  wanted=(devices inverse-samples forward-kernels forward-scaling forward-headline)
fi
studies=${BENCH_KAPPAMU:-build/app/kappamu-studies}
if ((!draw)); then
  [[ -n ${BENCH_KAPPAMU:-} ]] || scripts/build.sh release kappamu-studies
  read -ra under <<<"${BENCH_UNDER:-}"
  for what in "${wanted[@]}"; do
    echo "bench: $what"
    more=()
    [[ $what == *-* ]] && more=(--section "${what#*-}")
    ((gpu)) && [[ $what == inverse-samples ]] && more+=(--sample marble)
    [[ $what == slabs ]] && more=(--data "${BENCH_SLABS:-../shared/data/slab-rt-iad}")
    "${under[@]}" "$studies" "${what%%-*}" -o "$out" "${size[@]}" "${more[@]}" || {
      status=$?
      ((gpu)) || exit "$status"
      failed+=("$what")
    }
  done
fi
studies/bench_charts.py "$out" "${pages[@]}"
if ((gpu)); then
  {
    echo "# A GPU beside the processor"
    for what in "${wanted[@]}"; do
      if [[ -f $out/$what.md ]]; then printf '\n## %s\n\n' "$what"; cat "$out/$what.md"; fi
    done
  } >"$out/README.md"
  echo "bench: the page is $out/README.md"
  ((${#failed[@]} == 0)) || { echo "bench: failed: ${failed[*]}" >&2; exit 1; }
fi

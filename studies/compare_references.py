#!/usr/bin/env python3
"""Whether two folders of objects' references differ by more than their noise.

    studies/compare_references.py studies/objects/references out/references

Per scene: chi2 per patch of the differences over both standard errors, and the share of patches
that differ by more than four; with equal seeds the walks are no independent ones.
"""
import json
import math
import pathlib
import sys


def main():
    first, second = (pathlib.Path(folder) for folder in sys.argv[1:3])
    rows = []
    for file in sorted(first.glob("*.json")):
        if not (second / file.name).exists():
            continue
        a, b = (json.loads((folder / file.name).read_text()) for folder in (first, second))
        scores = [(y - x) / math.hypot(s, t)
                  for x, y, s, t in zip(a["exitance"], b["exitance"], a["standard_error"], b["standard_error"])
                  if s > 0 or t > 0]
        rows.append((sum(z * z for z in scores) / len(scores), sum(abs(z) > 4 for z in scores), len(scores), file.stem))
    for chi2, far, patches, name in sorted(rows, reverse=True):
        print(f"{name:40s} chi2 {chi2:5.2f}   beyond four deviations {far} of {patches}")
    print(f"{len(rows)} scenes; chi2 at most {max(row[0] for row in rows):.2f}; "
          f"{sum(row[1] for row in rows)} of {sum(row[2] for row in rows)} patches beyond four deviations")


if __name__ == "__main__":
    main()

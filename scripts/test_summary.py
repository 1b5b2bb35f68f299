#!/usr/bin/env python3
"""What a run of CTest came to, from its JUnit file: what the slow tests took, and what was skipped and why.

usage: test_summary.py BUILD        (BUILD/results.xml is the JUnit file)
"""
import collections
import json
import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree as ET


def main():
    build = pathlib.Path(sys.argv[1])
    cases = ET.parse(build / "results.xml").getroot().findall("testcase")
    known = subprocess.run(["ctest", "--test-dir", str(build), "-L", "slow", "--show-only=json-v1"],
                           capture_output=True, text=True, check=True).stdout
    names = {test["name"] for test in json.loads(known)["tests"]}
    slow = [case for case in cases if case.get("name") in names]
    if slow:
        print(f"slow tests: {len(slow)}, {sum(float(c.get('time')) for c in slow):.0f} s of "
              f"{sum(float(c.get('time')) for c in cases):.0f} s (leave them out with -LE slow)")
    reasons = collections.Counter()
    for case in cases:
        if case.get("status") == "notrun" or case.find("skipped") is not None:
            text = case.findtext("system-out") or ""
            said = re.search(r": Skipped\n(.+)", text)
            reasons[said.group(1).strip() if said else "no reason given"] += 1
    why = "; ".join(f"{n}: {reason}" for reason, n in reasons.most_common())
    print(f"skipped tests: {sum(reasons.values())} of {len(cases)}" + (f" ({why})" if why else ""))
    failed = sum(case.get("status") == "fail" for case in cases)
    print(f"{len(cases) - failed - sum(reasons.values())} passed, {failed} failed, {sum(reasons.values())} skipped")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Puts measured tables into a page: between `<!-- bench:NAME -->` and `<!-- /bench -->` goes FOLDER/table-NAME.md.

    scripts/bench_tables.py FOLDER docs/benchmarks.md

A table that was not measured leaves its place as it is.
"""
import os
import pathlib
import re
import sys


def renewed(page, folder):
    def table(match):
        file = folder / f"table-{match.group(2)}.md"
        return match.group(1).rstrip() + "\n\n" + file.read_text().strip() + "\n\n" + match.group(4) if file.exists() else match.group(0)
    return re.sub(r"(<!-- bench:([a-z-]+) -->\n\n?)(.*?)(<!-- /bench -->)", table, page, flags=re.S)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    folder, page = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    temporary = page.with_suffix(".tmp")
    temporary.write_text(renewed(page.read_text(), folder))
    os.replace(temporary, page)


if __name__ == "__main__":
    main()

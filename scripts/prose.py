#!/usr/bin/env python3
"""Measures the sentences of README.md and of the pages of docs/: words a sentence in the mean, and the longest.

    scripts/prose.py [ROOT]      exit code 1 where a page's mean is above 20 words or a sentence above 45

Cells of a table and items of a list count as sentences; code and what stands in backquotes counts as one word.
"""
import pathlib
import re
import sys

MOST_IN_THE_MEAN, MOST = 20, 45
SENTENCE_ENDS = re.compile(r"(?<=[.?!])\s+(?=[A-Z0-9κμφχ*`(])")
WORD = re.compile(r"[A-Za-z][A-Za-z'’-]*")
FEWEST = 4  # words: fewer are a heading or a number with its unit


def paragraphs(page):
    """The running text of each paragraph, and each cell of its tables."""
    page = re.sub(r"```.*?```|<!--.*?-->", " ", page, flags=re.S)
    for block in re.split(r"\n\s*\n", page):
        lines = [line for line in block.splitlines() if not re.match(r"\s*#|    |\s*!\[|\s*-{3,}", line)]
        for line in lines:
            if line.lstrip().startswith("|"):
                yield from line.strip().strip("|").split("|")
        yield " ".join(re.sub(r"^\s*[-*\d.]+\s+", ". ", line) for line in lines if not line.lstrip().startswith("|"))


def sentences(page):
    """(words, sentence) of each."""
    for text in paragraphs(page):
        text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
        for sentence in SENTENCE_ENDS.split(re.sub(r"`[^`]*`", "code", text)):
            words = len(WORD.findall(sentence))
            if words >= FEWEST:
                yield words, sentence.strip()


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent.parent)
    over = 0
    pages = [root / "README.md", *sorted((root / "docs").rglob("*.md"))]
    for page in pages:
        found = list(sentences(page.read_text()))
        if not found:
            continue
        mean, (most, longest) = sum(words for words, _ in found) / len(found), max(found)
        if mean > MOST_IN_THE_MEAN or most > MOST:
            over += 1
            print(f"prose: {page.relative_to(root)}: {mean:.1f} words a sentence, the longest {most}: {longest[:200]}")
    print(f"prose: {over} of {len(pages)} pages have sentences that are too long")
    return over > 0


if __name__ == "__main__":
    sys.exit(main())

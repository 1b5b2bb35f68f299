"""Numbers as text, tables and the look of charts."""
import math
import re

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import LogFormatter

# Okabe and Ito's palette (2008), distinguishable by colour-blind readers, and four darker colours.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8C6D00",
           "#7F3C8D", "#666666", "#A50026", "#2F6B3A"]
MARKS = "sov^D<>phX"
GREY = COLOURS[9]
plt.rcParams.update({"font.size": 9, "axes.grid": True, "grid.color": "#d8d8d8", "axes.titlesize": 10,
                     "axes.axisbelow": True, "legend.fontsize": 8, "lines.linewidth": 1.5, "lines.markersize": 5})


# ---- Texts and tables

def short(value):
    """Two significant digits; 1e-06 reads 1e-6."""
    if value is None:
        return "–"
    if not isinstance(value, float):
        return str(value)
    return re.sub(r"e([+-])0*(\d)", lambda m: "e" + m.group(1).replace("+", "") + m.group(2), f"{value:.2g}")


def percent(share, digits=0):
    return "–" if share is None else f"{100 * share:.{digits}f} %"


def fine_percent(share):
    return percent(share, 2 if share < 0.00995 else 1 if share < 0.0995 else 0)


FOLDED = 20  # rows: a longer table is folded


def table(head, rows):
    lines = [head, ["---"] * len(head)] + [list(row) for row in rows]
    text = "".join("| " + " | ".join(str(cell) for cell in line) + " |\n" for line in lines)
    text = text.replace("| --- " * len(head) + "|", "|---" * len(head) + "|")
    count = len(lines) - 2
    return text if count <= FOLDED else f"<details><summary>{count} rows</summary>\n\n{text}\n</details>\n"


def flat(rows, names, formats=None):
    formats = formats or {}
    return table(names, [[formats.get(name, short)(row.get(name)) for name in names] for row in rows])


def cross(rows, line, column, cell):
    """A line for each value of `line`, a column for each of `column`; both are keys or functions of a row."""
    at = [key if callable(key) else (lambda row, key=key: short(row[key])) for key in (line, column)]
    name = [key.__doc__ if callable(key) else key for key in (line, column)]
    cells = {(at[0](row), at[1](row)): cell(row) for row in rows}
    columns = unique(rows, at[1])
    return table([name[0]] + [f"{name[1]} {c}" for c in columns],
                 [[label] + [cells.get((label, c), "") for c in columns] for label in unique(rows, at[0])])


def unique(rows, key):
    return list(dict.fromkeys(key(row) if callable(key) else row[key] for row in rows))


def provenance(record):
    machine, program = record["machine"], record["program"]
    device = next((row["device"] for row in record.get("rows", []) if "device" in row), record["device"])
    size = {"full": "", "small": "; the small form of the command", "quick": "; QUICK form, toy problems"}[record["size"]]
    return (f"Measured on {machine['cpu']}, {machine['cores']} cores, copy "
            f"{machine['copy_bandwidth_bytes_per_second'] / 1e9:.1f} GB/s, load {machine['load']:.1f} before; "
            f"device {device}; kappamu {program['kappamu']}, {program['compiler']}, {program['build']}{size}.\n")


# ---- Charts

class PlainNumbers(LogFormatter):
    """0.3, not 3e-1, at the ticks of a logarithmic axis."""

    def _num_to_string(self, x, vmin, vmax):
        return f"{x:g}"


def panels(count, columns=2, width=7.0, height=4.4):
    columns = min(columns, count)
    rows = -(-count // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(width * columns, height * rows), squeeze=False,
                                constrained_layout=True)
    for unused in axes.flat[count:]:
        unused.set_visible(False)
    return figure, list(axes.flat[:count])


def dress(ax, title, x_label, y_label, log="", legend="best"):
    ax.set(title=title, xlabel=x_label, ylabel=y_label)
    for name, axis in (("x", ax.xaxis), ("y", ax.yaxis)):
        if name in log:
            ax.set(**{name + "scale": "log"})
            low, high = axis.get_view_interval()
            if high < 100 * low:  # within two decades plain numbers are easier to read than powers
                axis.set_major_formatter(PlainNumbers())
                axis.set_minor_formatter(PlainNumbers(minor_thresholds=(2, 0.5)))
    if not any(len(line.get_xdata()) for line in ax.lines):
        raise SystemExit(f"bench_charts: chart '{title}' has no point to draw")
    if any(not line.get_label().startswith("_") for line in ax.lines):
        if legend == "outside":
            ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0))
        else:
            ax.legend(loc=legend)


def line(ax, number, x, y, label, style="-", **options):
    """Line and marks of the number's colour; dashes and dots have no marks."""
    mark = {"marker": MARKS[number % len(MARKS)], "markerfacecolor": "none"} if style == "-" else {}
    points = [(a, b) for a, b in zip(x, y) if b is not None and math.isfinite(b)]
    ax.plot([p[0] for p in points], [p[1] for p in points], style, color=COLOURS[number % len(COLOURS)],
            label=label, **{**mark, **options})

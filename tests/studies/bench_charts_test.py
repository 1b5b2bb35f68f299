#!/usr/bin/python3
"""studies/bench_charts.py: numbers as text, tables, pages renewed in place, ratios, and charts refused without a point.

    tests/studies/bench_charts_test.py SOURCE_FOLDER      exit code 77: python3-matplotlib is not installed
"""
import pathlib
import sys
import tempfile
import unittest

try:
    import matplotlib
except ImportError:
    sys.exit(77)

ROOT = pathlib.Path(sys.argv.pop())
sys.path.insert(0, str(ROOT / "studies"))
import bench_charts  # noqa: E402
from charts import common, devices, forward, inverse, limits  # noqa: E402


ROWS = [{"kind": "a", "contrast": 1.0, "count": 3}, {"kind": "a", "contrast": 1e4, "count": 4},
        {"kind": "b", "contrast": 1e4, "count": 5}]


class Tables(unittest.TestCase):
    def test_numbers_are_short(self):
        self.assertEqual([common.short(x) for x in (1.2345e-6, 1e6, 1e-12, 0.25, 17, "a", None)],
                         ["1.2e-6", "1e6", "1e-12", "0.25", "17", "a", "–"])
        self.assertEqual([common.fine_percent(x) for x in (0.0021, 0.0499, 0.11)], ["0.21 %", "5.0 %", "11 %"])

    def test_lines_and_columns_are_crossed(self):
        self.assertEqual(common.cross(ROWS, "kind", "contrast", lambda r: r["count"]),
                         "| kind | contrast 1 | contrast 1e4 |\n|---|---|---|\n| a | 3 | 4 |\n| b |  | 5 |\n")

    def test_columns_asked_for_are_listed(self):
        self.assertEqual(common.flat(ROWS[2:], ["count", "kind"]), "| count | kind |\n|---|---|\n| 5 | b |\n")

    def test_a_note_is_shown_once_and_warnings_always(self):
        rows = [{"case": c, "warnings": ["w"] if c == "x" else [], "notes": ["The same note, 1."]} for c in "xy"]
        self.assertEqual(limits.sentences(rows).split("\n\n")[1],
                         '- **x**: `w`, note `The same note, 1.`\n- **y**: no warning\n')


class Ratios(unittest.TestCase):
    def test_first_to_reach_is_the_first_point_that_good(self):
        course = [{"solves": 10 * k, "validation_E": 10.0 ** -k} for k in range(3)]
        self.assertIs(inverse.first_to_reach(course, 0.1), course[1])
        self.assertIs(inverse.first_to_reach(course, 0.05), course[2])
        self.assertIsNone(inverse.first_to_reach(course, 1e-3))

    def test_a_solver_is_quoted_by_its_cheapest_sample_within_each_error(self):
        sample = lambda seconds, error: {"seconds_per_rhs": seconds, "true_error": error, "set_up_seconds": 1.5}
        lines = forward.reached([sample(1.0, 5e-3), sample(2.0, 9e-5), sample(0.5, 8e-3)], lambda s: "ours")
        self.assertEqual(lines.splitlines()[2], "| ours | 0.5000 | 2.0000 | – | 9.0e-05 | 1.500 |")

    def test_a_fixed_weight_may_end_above_its_best(self):
        point = lambda solves, error: {"solves": solves, "work": 2.0 * solves, "validation_E": error}
        ours = {"course": [point(10, 1e-2), point(20, 1e-3)], "validation_E": 1e-3, "batched_solves": 20}
        other = {"course": [point(40, 5e-2), point(60, 1e-3), point(80, 1e-2)], "validation_E": 1e-2, "batched_solves": 80}
        self.assertEqual(inverse.against_default(ours, other), ["1.0e-03", "3.0", "3.0", "8.0"])


class Devices(unittest.TestCase):
    MACHINE = {"machine": {"cpu": "c", "cores": 2, "copy_bandwidth_bytes_per_second": 1e9, "load": 0.0}, "size": "full",
               "program": {"kappamu": "1", "compiler": "g", "build": "Release"}, "device": "auto"}

    def row(self, kind, seconds, **more):
        return {"task": "solve", "device": kind.lower(), "kind": kind, "size": "big", "seconds": seconds, "set_up_seconds": 0.25,
                "rate": 3.0, "unit": "pieces", "note": "", "difference": 1e-7, "allowed": 2e-6, "times_processor": 1 / seconds,
                "goal": "≤ 8 ms", "goal_met": None, **more}

    def lines(self, rows, folder="nowhere"):
        text = devices.devices({**self.MACHINE, "rows": rows, "folder": folder})[1][""]
        return [line for line in text.splitlines() if line.startswith("| solve | big") or line.startswith("| fit of")]

    def test_a_task_is_a_line_with_a_column_for_each_kind(self):
        rows = [self.row("GPU", 0.007, goal_met=True), self.row("CPU", 0.5), self.row("host", 2.0)]
        self.assertEqual(self.lines(rows), ["| solve | big | 2 s | 0.5 s | 7 ms | 143 | ≤ 8 ms | met |"])
        self.assertEqual(self.lines(rows[1:]), ["| solve | big | 2 s | 0.5 s | – | ≤ 8 ms | not measured |"])

    def test_unequal_answers_have_no_ratio_and_a_refused_task_no_time(self):
        unequal = self.row("GPU", 0.007, times_processor=None, goal_met=False, refused="differs")
        self.assertEqual(self.lines([unequal, self.row("host", 2.0)]),
                         ["| solve | big | 2 s | 7 ms | – | ≤ 8 ms | missed |"])
        refused = {"task": "solve", "device": "g", "kind": "GPU", "refused": "out of memory"}
        self.assertEqual(self.lines([refused, self.row("host", 2.0)]),
                         ["| solve | big | 2 s | refused | – | ≤ 8 ms | not measured |"])

    def test_marble_is_taken_from_the_samples_measured_beside(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "inverse-samples.json").write_text(
                '{"size": "full", "rows": [{"sample": "marble", "seconds": 6.0, "grid": [2, 3, 4]}]}')
            self.assertEqual(self.lines([self.row("host", 2.0), self.row("CPU", 1.0)], folder)[1],
                             "| fit of marble, RGB | 2 × 3 × 4 |  | 6 s | – | ≤ 5 s | not measured |")
            self.assertEqual(self.lines([self.row("GPU", 2.0), self.row("CPU", 1.0)], folder)[1],
                             "| fit of marble, RGB | 2 × 3 × 4 |  | 6 s | – | ≤ 5 s | missed |")


class Pages(unittest.TestCase):
    PAGE = ("x\n<!-- bench:one -->\n\nold\n\n<!-- /bench -->\ny\n<!-- bench:two -->\nkept\n<!-- /bench -->\n")

    def test_a_text_replaces_its_place_and_no_other(self):
        renewed = bench_charts.renewed(self.PAGE, {"one": "new\n", "three": "lost"})
        self.assertEqual(renewed, self.PAGE.replace("old", "new"))
        self.assertEqual(bench_charts.renewed(renewed, {"one": "new\n"}), renewed)

    def test_every_table_of_the_limits_has_its_place(self):
        page = "".join(file.read_text() for file in (ROOT / "docs").glob("limits-*.md"))
        for name in bench_charts.LIMITS:
            self.assertIn(f"<!-- bench:limits-{name} -->\n", page)

    def test_every_place_and_picture_of_a_page_is_made_by_a_subject(self):
        ends = ("", "-views", "-coverage", "-exposures", "-thesis", "-fit")
        made = {stem + end for stem in bench_charts.SUBJECTS for end in ends}
        for page in sorted((ROOT / "docs").glob("*.md")):
            for name in bench_charts.re.findall(r"<!-- bench:([a-z-]+) -->", page.read_text()):
                self.assertIn(name, made, page.name)

    def test_a_foreign_record_and_an_empty_folder_are_refused(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            self.assertEqual(bench_charts.draw(folder), ({}, {}))
            (folder / "hdr.json").write_text("{}")
            with self.assertRaisesRegex(SystemExit, "measure again"):
                bench_charts.draw(folder)


class Charts(unittest.TestCase):
    def test_a_picture_has_the_colours_of_its_series(self):
        figure, (ax,) = common.panels(1)
        common.line(ax, 0, [1, 10], [0.1, 1.0], "first")
        common.line(ax, 1, [1, 10], [0.2, 3.0], "second")
        common.dress(ax, "two lines", "error", "seconds", "xy")
        with tempfile.TemporaryDirectory() as folder:
            file = folder + "/chart.png"
            figure.savefig(file, dpi=100)
            pixels = matplotlib.image.imread(file)[..., :3]
        for colour in common.COLOURS[:2]:
            near = abs(pixels - matplotlib.colors.to_rgb(colour)).max(axis=2) < 0.01
            self.assertGreater(near.sum(), 100)
        self.assertEqual((ax.get_xscale(), ax.get_yscale()), ("log", "log"))

    def test_a_chart_without_a_point_is_refused(self):
        _, (ax,) = common.panels(1)
        common.line(ax, 0, [1.0], [None], "nothing")
        with self.assertRaisesRegex(SystemExit, "no point to draw"):
            common.dress(ax, "empty", "x", "y")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

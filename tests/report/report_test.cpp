// The report as a reader gets it: which verdict a run earns, that the page stands alone, and that a
// browser shows it. What stands in the numbers is tested where they are computed.
#include "report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "io/atomic_file.h"
#include "io/image/image_file.h"
#include "io/read_file.h"
#include "report/drawing/chart.h"
#include "report/drawing/cutaway.h"
#include "report/drawing/picture.h"
#include "report/drawing/slices.h"
#include "report/sections.h"
#include "tests/app/process.h"
#include "tests/report/made_up_run.h"
#include "tests/sentence.h"

namespace kappamu::report {
namespace {

using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

fs::path written(const fs::path& run) {
  fs::path file = run / "report.html";
  write_report(run, file);
  return file;
}

class ReportTest : public TemporaryFolderTest {
 protected:
  std::string page(const MadeUpRun& options) {
    return io::read_text(written(make_run(folder(), options)));
  }
};

std::size_t count(const std::string& in, const std::string& what) {
  std::size_t found = 0;
  for (std::size_t at = in.find(what); at != std::string::npos; at = in.find(what, at + 1)) ++found;
  return found;
}

TEST_F(ReportTest, OpensWithTheVerdictOfTheFit) {
  const std::string good = page({});
  EXPECT_THAT(good, HasSubstr("<h2>This fit can be trusted.</h2>"));
  EXPECT_EQ(count(good, "class=\"lamp green\""), 5U);
  MadeUpRun wrong;
  wrong.model_error = 0.5;
  const std::string bad = io::read_text(written(make_run(folder() / "wrong", wrong)));
  EXPECT_THAT(bad, HasSubstr("<h2>Do not trust this fit: E = 0.25 over 1 pattern"));
  EXPECT_THAT(bad, HasSubstr("class=\"lamp red\""));
}

TEST_F(ReportTest, HasOneDefinitionOfEAndOfChi2) {
  const std::string html = page({});
  EXPECT_EQ(count(html, "E = Σ(L′ − L)²/ΣL²"), 1U);
  EXPECT_EQ(count(html, "mean of (L′ − L)²/σ²"), 1U);
  // χ² is of the fitted values: patterns show E alone.
  EXPECT_EQ(count(html, "E of this pattern"), 8U);
  EXPECT_EQ(count(html, ">χ² "), count(html, ">χ² per value")) << "one χ² on the page";
}

TEST_F(ReportTest, AppearanceErrorIsOfWhatTheMaskAllows) {
  Comparison comparison;
  comparison.measured.grid = {2, 1, 1, 1.0};
  comparison.measured.channels = {"Y"};
  comparison.measured.patterns = 2;
  comparison.measured.value = {3.0F, 100.0F, 1.0F, 1.0F};
  comparison.measured.variance = {0.25F, 1.0F, 0.5F, 0.5F};
  comparison.measured.mask = {1, 0, 1, 1};
  comparison.predicted = {4.0F, 0.0F, 1.0F, 2.0F};
  EXPECT_DOUBLE_EQ(appearance_error(comparison, 0).E(), 1.0 / 9.0);
  EXPECT_DOUBLE_EQ(appearance_error(comparison, 1).E(), 1.0 / 2.0);
  EXPECT_DOUBLE_EQ(appearance_error(comparison).E(), 2.0 / 11.0);
  EXPECT_DOUBLE_EQ(appearance_error(comparison).noise_E(), 1.25 / 11.0);
}

TEST_F(ReportTest, PageStandsAlone) {
  const std::string html = page({});
  EXPECT_EQ(count(html, "<script"), 1U) << "the slider's";
  EXPECT_THAT(html, Not(HasSubstr("<link")));
  EXPECT_THAT(html, Not(HasSubstr("http:")));
  EXPECT_THAT(html, Not(HasSubstr("https:")));
  EXPECT_THAT(html,
              HasSubstr("http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'"));
  EXPECT_THAT(html, Not(HasSubstr("@import")));
  // Every picture is inline, and PNG by its signature.
  EXPECT_EQ(count(html, "<img "), count(html, "src=\"data:image/png;base64,iVBORw0KGgo"));
  EXPECT_EQ(count(html, "src="), count(html, "<img "));
  EXPECT_LT(html.size(), std::size_t{10} << 20);
  EXPECT_THAT(html, Not(HasSubstr(folder().string()))) << "the machine is no reader's business";
}

/// A browser runs the slider's script by its hash alone.
TEST_F(ReportTest, PolicyAllowsTheSlidersScript) {
  io::write_text_atomically(folder() / "slider.js", slider_script);
  const std::string program =
      "import base64, hashlib; print(base64.b64encode(hashlib.sha256(open('" +
      (folder() / "slider.js").string() + "', 'rb').read()).digest()).decode())";
  const std::string sum = (folder() / "sum.txt").string();
  ASSERT_EQ(std::system(("python3 -c \"" + program + "\" > '" + sum + "'").c_str()), 0);
  EXPECT_EQ(io::read_text(sum), std::string(slider_script_sha256) + "\n");
  EXPECT_THAT(page({}), HasSubstr("script-src 'sha256-" + std::string(slider_script_sha256) + "'"));
  EXPECT_THAT(page({}), HasSubstr("<script>" + std::string(slider_script) + "</script>"));
}

TEST_F(ReportTest, WhatIsNotGreenSaysWhatToDo) {
  const std::string html = page({});
  EXPECT_THAT(html, HasSubstr("What to do next"));
  for (const char* link :
       {"#measured-against-rerendered", "#geometric-calibration", "#warnings-times-provenance"}) {
    EXPECT_THAT(html, HasSubstr("href=\"" + std::string(link) + "\""));
    EXPECT_THAT(html, HasSubstr("<section id=\"" + std::string(link + 1) + "\""));
  }
}

TEST(Cutaway, ShowsTheInsideOfTheCornerThatIsCutAway) {
  const GridShape shape{16, 16, 16, 1.0};
  const Medium pale{Volume<double>(shape, 0.3), Volume<double>(shape, 0.001)};
  const auto darkest = [&](int x, int y, int z) {
    Medium medium = pale;
    medium.mu(x, y, z) = 1.0;
    const Image<std::uint8_t> image = cutaway({medium}, 1.3, 200);
    return *std::min_element(image.values().begin(), image.values().end());
  };
  const int usual = darkest(2, 13, 14);  // deep inside
  EXPECT_EQ(darkest(12, 3, 3), usual) << "cut away";
  EXPECT_LT(darkest(12, 3, 8), usual - 50) << "behind the corner";
  EXPECT_LT(darkest(3, 8, 0), usual - 50) << "on the lit face";
  EXPECT_LT(darkest(15, 12, 8), usual - 50) << "on the right";
  EXPECT_EQ(darkest(8, 8, 15), usual) << "on the far face";
}

TEST_F(ReportTest, ShowsEveryPatternChannelAndSection) {
  const std::string html = page({});
  for (const char* heading :
       {"What was captured", "Geometric calibration", "Response and dynamic range", "Convergence",
        "Volumes", "Uncertainty", "Measured against re-rendered", "Validation patterns",
        "Warnings, times, provenance"})
    EXPECT_THAT(html, HasSubstr(heading));
  for (const char* id : {"fit_00", "fit_05", "validate_00", "validate_01"})
    EXPECT_THAT(html, HasSubstr("alt=\"re-rendered of " + std::string(id) + "\""));
  for (const char* map : {"dynamic range", "relative noise", "saturation"})
    EXPECT_THAT(html, HasSubstr("alt=\"" + std::string(map) + " of fit_00\""));
  for (const char* channel : {"R", "G", "B"})
    EXPECT_THAT(html, HasSubstr("alt=\"residual " + std::string(channel) + " of fit_00\""));
  EXPECT_THAT(html, HasSubstr("Model of G: volume. Simpler ones leave chi2 at 40."));
  EXPECT_THAT(html, HasSubstr("a made-up device"));
  EXPECT_THAT(html, HasSubstr("white target under 4 pixel values"));
  EXPECT_THAT(html, HasSubstr("The projector's black is 1 : 2000 of its white. The room's light on "
                              "the target, 1 % of the projector's white"));
  EXPECT_THAT(html, HasSubstr("before face z-: x to the right, y down. The other pictures as seen "
                              "by the camera, before face z+: x to the left, y down."));
  // Where the data say nothing, in words and in pictures.
  EXPECT_THAT(html, HasSubstr("Beyond 3 mm below the seen face the data say nothing about G."));
  for (const char* picture : {"σ of log κ at z = ", "σ of log μ at x = ", "resolution of κ at y = ",
                              "resolution of μ at z = "})
    EXPECT_THAT(html, HasSubstr("alt=\"" + std::string(picture)));
}

TEST_F(ReportTest, MeasurementsOfAnyoneAreReportedWithoutTheMissingParts) {
  MadeUpRun options;
  options.with_session = false;
  const std::string html = page(options);
  EXPECT_THAT(html, HasSubstr("This run has no calibration"));
  EXPECT_THAT(html, HasSubstr("This run has no HDR images"));
  EXPECT_THAT(html, HasSubstr("No patterns were kept out of the fit for validation"));
  EXPECT_THAT(html, HasSubstr("alt=\"re-rendered of pattern 0\""));
}

TEST_F(ReportTest, LargeRunsStaySmall) {
  MadeUpRun options;
  options.nx = 256;
  options.ny = 256;
  options.nz = 20;
  options.fit_patterns = 16;
  options.validate_patterns = 4;
  EXPECT_LT(page(options).size(), std::size_t{10} << 20);
}

TEST_F(ReportTest, EmptyFolderIsRefusedInOneSentence) {
  const std::string sentence = sentence_of([&] { written(folder()); });
  EXPECT_THAT(sentence, HasSubstr("holds nothing to report"));
}

TEST_F(ReportTest, DamagedFitIsNamed) {
  const fs::path run = make_run(folder(), {});
  io::write_text_atomically(run / "fit" / "fit.json", "{\"channels\": [");
  const std::string sentence = sentence_of([&] { written(run); });
  EXPECT_THAT(sentence, HasSubstr("fit.json"));
}

TEST(HtmlTest, PlainTextIsEscaped) {
  EXPECT_EQ(text("a<b & \"c\"").markup(), "a&lt;b &amp; &quot;c&quot;");
  EXPECT_EQ(element("p", {{"title", "1 < 2"}}, text(">")).markup(),
            "<p title=\"1 &lt; 2\">&gt;</p>\n");
}

TEST(HtmlTest, NumbersKeepTheirDigits) {
  EXPECT_EQ(number(0.012345), "0.0123");
  EXPECT_EQ(number(123456.0), "123456");
  EXPECT_EQ(number(1.5e-5, 2), "1.5e-05");
  EXPECT_EQ(duration(3.21), "3.2 s");
  EXPECT_EQ(duration(200.4), "3 min 20 s");
  EXPECT_EQ(percent(0.5), "50 %");
}

TEST(PictureTest, ColourMapsAreMonotoneInLightness) {
  // Perceptual order: relative luminance of viridis rises from end to end; the diverging map's is
  // even about its middle.
  const auto luminance = [](ColourMap map, double at) {
    const auto colour = colour_of(map, at);
    return 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2];
  };
  for (int i = 1; i <= 64; ++i)
    EXPECT_GT(luminance(ColourMap::viridis, i / 64.0),
              luminance(ColourMap::viridis, (i - 1) / 64.0));
  EXPECT_GT(luminance(ColourMap::diverging, 0.5), luminance(ColourMap::diverging, 0.0));
  EXPECT_GT(luminance(ColourMap::diverging, 0.5), luminance(ColourMap::diverging, 1.0));
}

TEST(PictureTest, ReductionKeepsTheMean) {
  Image<float> image(7, 5, 1, 0.0F);
  image(6, 4) = 3.0F;
  const Image<float> small = reduced(image, 4);
  EXPECT_EQ(small.width(), 4);
  EXPECT_EQ(small.height(), 3);
  EXPECT_FLOAT_EQ(small(3, 2), 3.0F);  // a corner block of one pixel keeps its value
}

TEST(ChartTest, NothingToDrawIsEmpty) {
  LineChart chart;
  chart.log_y = true;
  chart.series.push_back({"R", "#000", {1.0, 2.0}, {0.0, -1.0}, false});
  EXPECT_TRUE(render(chart).empty());
  EXPECT_TRUE(render(BarChart{}).empty());
  EXPECT_TRUE(render(PointChart{}).empty());
}

// ---- In a browser ------------------------------------------------------------------------------

class BrowserTest : public ReportTest {
 protected:
  void SetUp() override {
    ReportTest::SetUp();
    if (run_process("command -v chromium").exit_code != 0)
      GTEST_SKIP() << "chromium is not installed: the report is not looked at in a browser here";
  }
  /// Headless chromium with a profile of its own.
  ProcessResult chromium(const std::string& options, const fs::path& file) {
    return run_process(
        "timeout 90 chromium --headless=new --no-sandbox --disable-gpu --user-data-dir=" +
        (folder() / "profile").string() + " " + options + " file://" + file.string());
  }
};

TEST_F(BrowserTest, ShowsTitleAndDecodesEveryPicture) {
  const fs::path report = written(make_run(folder(), {}));
  // A copy with a script that lists what the browser could not decode; the page itself allows none.
  const fs::path copy = folder() / "probe.html";
  std::string allowed = io::read_text(report);
  const std::string policy = "default-src 'none'";
  ASSERT_EQ(count(allowed, policy), 1U);
  allowed.replace(allowed.find(policy), policy.size(), "script-src 'unsafe-inline'");
  io::write_text_atomically(
      copy, allowed +
                "<script>const bad=[...document.images].filter(i=>!(i.complete&&i.naturalWidth>0));"
                "document.title+=' | images '+document.images.length+' bad '+bad.length;"
                "</script>");
  const ProcessResult result = chromium("--dump-dom", copy);
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  const std::size_t images = count(io::read_text(report), "<img ");
  EXPECT_THAT(result.standard_output, HasSubstr("<title>kappamu report: made-up block | images " +
                                                std::to_string(images) + " bad 0</title>"));
}

TEST_F(BrowserTest, ScreenshotIsNotBlank) {
  const fs::path report = written(make_run(folder(), {}));
  const fs::path picture = folder() / "screenshot.png";
  const ProcessResult result = chromium(
      "--hide-scrollbars --window-size=1200,3000 --screenshot=" + picture.string(), report);
  ASSERT_EQ(result.exit_code, 0) << result.standard_error;
  const Image<std::uint16_t> shot = io::read_code_image(picture);
  EXPECT_EQ(shot.width(), 1200);
  ASSERT_EQ(shot.height(), 3000);
  // Ink in every band of 300 rows: the page fills the picture.
  for (int band = 0; band < 10; ++band) {
    std::size_t ink = 0;
    for (int y = 300 * band; y < 300 * (band + 1); ++y)
      for (int x = 0; x < shot.width(); ++x) ink += shot(x, y, 0) < 200 ? 1 : 0;
    EXPECT_GT(ink, 500U) << "rows from " << 300 * band;
  }
}

}  // namespace
}  // namespace kappamu::report

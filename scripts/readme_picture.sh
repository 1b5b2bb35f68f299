#!/usr/bin/env bash
# Remakes docs/images/report.png, README's picture: the first screen of the demo's report, in a headless browser.
#   scripts/readme_picture.sh [REPORT.html]
set -euo pipefail
cd "$(dirname "$0")/.."
report=$(realpath "${1:-out/demo/run/report.html}")
mkdir -p docs/images
chromium --headless=new --no-sandbox --disable-gpu --hide-scrollbars --window-size=1200,1040 \
  --screenshot="$PWD/docs/images/report.png" "file://$report" >/dev/null 2>&1
echo "docs/images/report.png: the first screen of $report"

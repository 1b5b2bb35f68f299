#!/bin/sh
# with_screen.sh COMMAND...: runs it on a screen of its own. xvfb-run does too, but on a busy machine it can fail to
# remove its own folder, and then returns 5 in place of the command's code.
number=$(mktemp)
Xvfb -displayfd 3 -screen 0 1280x1024x24 -nolisten tcp 3>"$number" >/dev/null 2>&1 &
server=$!
trap 'kill "$server" 2>/dev/null; rm -f "$number"' EXIT
until [ -s "$number" ]; do
  kill -0 "$server" 2>/dev/null || { echo "with_screen: Xvfb did not start" >&2; exit 1; }
  sleep 0.02
done
DISPLAY=:$(cat "$number") "$@"

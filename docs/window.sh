#!/bin/sh
# Makes docs/window.png: the window over a demo, with the panels of its passes, its timeline and what a target holds.
#     docs/window.sh target/release/raxel
# Needs Xvfb, xdotool and ImageMagick. The project is copied, so that no file of it changes.
set -eu
raxel=$(realpath "${1:-target/release/raxel}")
root=$(realpath "$(dirname "$0")/..")
work=$(mktemp -d)
export DISPLAY=":${RAXEL_FILM_DISPLAY:-87}" WAYLAND_DISPLAY=''
window='' screen=''
trap 'kill $window $screen 2>/dev/null || true; rm -rf "$work"' EXIT
cp -r "$root/graphs" "$root/shaders" "$root/worlds" "$work"
cd "$work"
mkdir .raxel
cat >.raxel/window.toml <<'LAYOUT'
visible  = true
zoom     = 1.0
timeline = true

[docks.across]
share = 0.3
left  = { tabs = ["resources"] }

[docks.across.right.across]
share = 0.645
left  = { tabs = ["picture"] }
right = { tabs = ["inspect"] }
LAYOUT
Xvfb "$DISPLAY" -screen 0 1280x720x24 -nolisten tcp 2>/dev/null &
screen=$!
sleep 1
"$raxel" run worlds/valley.demo.toml --size 1280x720 --scale 0.5 2>log &
window=$!
until grep -q 'Escape quits' log; do sleep 0.2; done
xdotool windowfocus --sync "$(xdotool search --onlyvisible --name raxel | head -n 1)"
# The demo stands still at three seconds; the pointer rests on a texel.
xdotool key space
sleep 1
xdotool mousemove 553 604 click 1
sleep 5
xdotool mousemove 560 300
sleep 15
import -window root -depth 8 -define png:compression-level=9 "$root/docs/window.png"
ls -l "$root/docs/window.png"

#!/bin/sh
# Makes docs/edit.gif, the film of the README: an edit of a graph and one of a shader become pictures, a mistake is said, and mended.
#     docs/edit.sh target/release/raxel
# Needs Xvfb and ffmpeg. The project is copied; what is edited is the copy.
set -eu
raxel=$(realpath "${1:-target/release/raxel}")
root=$(realpath "$(dirname "$0")/..")
work=$(mktemp -d)
display=:${RAXEL_FILM_DISPLAY:-87}
trap 'kill $window $screen 2>/dev/null || true; rm -rf "$work"' EXIT
window='' screen=''
cp -r "$root/graphs" "$root/shaders" "$root/worlds" "$work"
cd "$work"
mkdir .raxel
cat >.raxel/window.toml <<'LAYOUT'
visible = true
zoom    = 1.0
left    = { size = 300.0 }
right   = { size = 340.0 }
bottom  = { open = "problems", size = 130.0 }
LAYOUT

# The line under the picture: the file, and what is written into it.
say() { printf '%s' "$1" >line.new; mv line.new line; }
# save FILE OLD NEW: replaces a text, as an editor does that renames.
save() {
    python3 -c 'import sys; f, old, new = sys.argv[1:]; text = open(f).read(); assert old in text, old
open(f + ".new", "w").write(text.replace(old, new, 1))' "$1" "$2" "$3"
    mv "$1.new" "$1"
}
# reloaded N: waits until the window has said N times that an edit runs, or failed.
reloaded() { while [ "$(grep -c '^reloaded\|^gen .* failed' log)" -lt "$1" ]; do sleep 0.1; done; }

Xvfb "$display" -screen 0 960x540x24 -nolisten tcp 2>/dev/null &
screen=$!
sleep 1
say ' '
DISPLAY=$display WAYLAND_DISPLAY='' "$raxel" run graphs/primary.toml --world worlds/valley.toml --size 960x540 --scale 0.5 2>log &
window=$!
sleep 6

text="textfile=line:reload=1:font=DejaVu Sans Mono:fontsize=20:fontcolor=white:x=16:y=552"
ffmpeg -loglevel error -y -f x11grab -draw_mouse 0 -framerate 10 -video_size 960x540 -i "$display" \
    -vf "pad=960:588:0:0:0x15171c,drawtext=$text" -c:v ffv1 film.mkv &
film=$!
sleep 1.5
say 'graphs/primary.toml      default = 6.0'
save graphs/primary.toml 'default = 32.0' 'default = 6.0'
reloaded 1
sleep 2.5
say 'shaders/primary.comp     return vec3(seen.hit.uv, 0.0);'
save shaders/primary.comp 'vec3 surface(Seen seen, RxMaterial material, vec3 sun) {
' 'vec3 surface(Seen seen, RxMaterial material, vec3 sun) {
    return vec3(seen.hit.uv, 0.0);
'
reloaded 2
sleep 2.5
say 'shaders/primary.comp     return vec3(seen.hit.vu, 0.0);'
save shaders/primary.comp 'seen.hit.uv, 0.0);' 'seen.hit.vu, 0.0);'
reloaded 3
sleep 4
say 'shaders/primary.comp     return vec3(seen.hit.uv, 1.0);'
save shaders/primary.comp 'seen.hit.vu, 0.0);' 'seen.hit.uv, 1.0);'
reloaded 4
sleep 2.5
kill -INT $film
wait $film || true
ffmpeg -loglevel error -y -i film.mkv \
    -vf 'fps=5,scale=720:-1:flags=lanczos,split[a][b];[a]palettegen=max_colors=96[p];[b][p]paletteuse=dither=bayer:bayer_scale=4:diff_mode=rectangle' "$root/docs/edit.gif"
ls -l "$root/docs/edit.gif"

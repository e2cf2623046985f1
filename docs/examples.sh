#!/bin/sh
# The pictures of graphs/examples/README.md: docs/examples.sh RAXEL, in the root of the repository.
set -eu
raxel=${1:-raxel}
mkdir -p docs/examples
for graph in graphs/examples/*.toml; do
    name=$(basename "$graph" .toml)
    case $name in
        flock) more="--world worlds/flock.toml" ;;
        fair | instances) more="--world worlds/fair.toml" ;;
        copy) more="--world worlds/meadow.toml" ;;
        drill) more="--world worlds/meadow.toml --set radius=10" ;;
        gamepad | microphone | paint) graph=worlds/$name.demo.toml more= ;;
        lantern) more="--world worlds/lantern.toml --set walk=30 --set mist=3" ;;
        model) more="--world worlds/valley.toml" ;;
        *) more= ;;
    esac
    # shellcheck disable=SC2086
    "$raxel" render "$graph" $more --size 240x135 --frames 120 -o "docs/examples/$name.png"
done
